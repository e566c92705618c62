"""Real sequences: video files, image folders, benchmarks, and a clip from pip."""

import os

import cv2

# What OpenCV and FFmpeg remark on stderr, our errors say in a sentence.
os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")  # quiet
cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_ERROR)
