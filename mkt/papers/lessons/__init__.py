"""Figures that no paper printed: those that teach, and the reader's own video.

Trackers: `mkt.papers.lessons.trackers`, a round of the particle filter in its
`mkt.papers.lessons.beats`, what appears by `mkt.papers.lessons.chance`,
`mkt.papers.lessons.bin_images`, `mkt.papers.lessons.planes`, and the four wishes of
[N03], `mkt.papers.lessons.wishes`, with their figures in `mkt.papers.lessons.wished`.
Who is better: `mkt.papers.lessons.benchmark`, `mkt.papers.lessons.survival`.  The
robot: `mkt.papers.lessons.servoing`, its control loop `mkt.papers.lessons.loops`.
Drawings at the head of chapters, made with `mkt.papers.lessons.pencil`:
`mkt.papers.lessons.drawings`, `mkt.papers.lessons.drawings_of_looks`,
`mkt.papers.lessons.drawings_of_cameras`.  And `mkt.papers.lessons.your_video`.
"""
