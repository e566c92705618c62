"""PFHR and SIR with the same look, so that hybrid resampling alone tells them apart.

A look is what a filter sees of a box: bins and kernel.  The paper's is that of our SIR,
every pixel of the box alike; ours is that of our PFHR, with bins for what has no hue
and a kernel that trusts the border of the box less than its middle.
"""

from dataclasses import replace

from mkt.trackers.by_name import PFHR, SIR, TRACKERS
from mkt.tracking import Tracker

RIVALS: dict[str, Tracker] = {
    "pfhr plain": replace(PFHR, bins=SIR.bins, kernels=SIR.kernels),
    "sir": SIR,
    "pfhr": PFHR,
    "sir ours": replace(SIR, bins=PFHR.bins, kernels=PFHR.kernels),
    "wm": TRACKERS["wm"],
}
# PFHR as the paper prints it: its acceptance test, and what its sign of an occlusion,
# a low N_eff, calls for.
PRINTED = replace(RIVALS["pfhr plain"], accept="paper", occlusion="n_eff")
# PFHR and SIR of each look.
LOOKS = {"the paper's look": ("pfhr plain", "sir"), "our look": ("pfhr", "sir ours")}
