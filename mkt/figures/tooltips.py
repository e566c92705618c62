"""What a slider of a figure is called, and what it means in a few words: its tooltip.

A name means the same in all figures; a caption says what is special in its figure.
"""

import re

# Names of parameters that a reader who does not program would stumble over; commands,
# files and links keep the parameters' own.
TITLES = {
    "believed_below": "believed below",
    "derivative_of_c": "derivative of C",
    "k": "frame",
    "lam": "lambda",
    "limit": "T_lim",
    "n": "particles",
    "n_lim": "N_lim",
    "ratio": "Q / R",
    "size_prior": "size prior",
    "t_lim": "T_lim",
}

WORDS = {
    "ahead": "how many frames the motion is foretold",
    "alpha": "how fast the model learns: the new look's share in each frame",
    "b": "the share of the samples that must look like the target for it to be there",
    "believed_below": "the share of O that a turn may leave and be believed",
    "bins": "which colours are told apart",
    "cast": "how much the light has changed its colour",
    "compensation": "how the target's own motion is made up for",
    "count": "bins of each channel",
    "counted": "what each cell counts",
    "covered": "the share of the target that something hides",
    "delay": "how long from the exposure to the command [frames]",
    "derivative_of_c": "whether the step also takes in how the kernels' sum changes",
    "dof": "how many of its six velocities the camera may use",
    "dx": "how far the start is displaced to the right [px]",
    "elliptic": "whether the kernel ends on the ellipse, and not on a circle round it",
    "epsilon": "the share of the background that looks like the target [%]",
    "exposure": "how long the shutter is open, as a share of a frame",
    "extent": "how far the surface reaches to each side [px]",
    "features": "what the robot gets: a tracker's region, or the true one, "
    "or one that is off by so many pixels",
    "fps": "frames per second",
    "frame": "the number of the frame",
    "gain": "how hard the camera is pulled to its place [1/s]",
    "grain": "noise of the sensor [grey levels]",
    "ground": "the picture behind the target",
    "growth": "how much larger the target is than the start",
    "height": "of the box, as a share of the picture",
    "item": "the object",
    "jitter": "how far the features are off by chance [px]",
    "k": "the number of the frame",
    "kind": "what happens in the scene",
    "lam": "lambda: how much better a small distance weighs",
    "largest": "the largest number of particles",
    "later": "how many frames later the box is looked for",
    "layout": "how the kernels lie in the box",
    "left": "the left edge of the box, as a share of the picture",
    "limit": "the overlap above which a frame is a hit",
    "look": "how the target has changed since it was learnt",
    "mismatch": "how many times too large the interaction matrix is thought to be",
    "motion": "how the target moves",
    "n": "how many particles",
    "n_lim": "the effective sample size below which is resampled, as a share",
    "noise": "of the motion, in multiples of our values",
    "occlusion": "how long the target is hidden [frames]",
    "off": "how far the calibration is wrong [px]",
    "particles": "how many guesses in each frame",
    "placement": "where the samples wait for the target",
    "profile": "how the weight falls from the middle of a kernel to its border",
    "ratio": "Q / R: how fast the target is thought to change, against the noise",
    "rho": "how long the target's velocity is thought to last, from frame to frame",
    "rounding": "how the decimals were printed",
    "row": "of the printed table",
    "scale": "how many times as large",
    "scene": "what happens to the target",
    "scheme": "how offspring are drawn",
    "seed": "another draw of the random numbers",
    "share": "the weight of the edges beside that of the colours",
    "shift": "how far the start is moved [px]",
    "sigma": "how sharply a small distance is told from a large one",
    "size_prior": "how strongly a change of size must be earned",
    "span": "the size of each kernel, as a share of its part of the box",
    "speed": "of the target",
    "start": "the frame in which the box is learnt, as a share of the video",
    "t_lim": "the overlap above which a frame is a hit",
    "talking": "whether the two cameras tell one another what they see",
    "threshold": "what must be exceeded before the model learns, or the optimiser runs",
    "tilt": "how far the plane leans away from the camera [deg]",
    "top": "the upper edge of the box, as a share of the picture",
    "tracker": "who follows the target",
    "tree": "the width of the tree [px]",
    "turn": "clockwise rotation [deg]",
    "turned": "how far the object has turned [deg]",
    "van": "what becomes of it: it takes other colours, it turns, or neither",
    "wall": "where the middle of the wall is [px]",
    "width": "of the box, as a share of the picture",
    "x": "to the right [px]",
    "y": "downwards [px]",
}


UNIT = re.compile(r" \[[^]]+\]$")  # at the end of the words


def title(name: str) -> str:
    """What the control of a parameter is called, with its unit if it has one."""
    unit = UNIT.search(WORDS.get(name, ""))
    return TITLES.get(name, name) + (unit[0] if unit else "")
