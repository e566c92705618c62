"""Tracking in a video of one's own.

Settings, recordings, the webcam, and the workbench in a notebook.
"""
