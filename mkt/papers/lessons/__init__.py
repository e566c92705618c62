"""Figures that no paper printed: those that teach, and the reader's own video."""
