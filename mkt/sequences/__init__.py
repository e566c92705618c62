"""Real sequences: video files, image folders, benchmarks, and a clip from pip."""
