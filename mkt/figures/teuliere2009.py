"""The figures of [T09]: C. Teulière, E. Marchand, L. Eck, ICRA 2009.

Its pages with Section II, figure 1 and equations (1) to (5) are lost; what stands here in their place says so.
"""

import numpy as np

from mkt.figures import figure
from mkt.histograms import ColorBins, histograms, learn
from mkt.kernels import PROFILES, Kernels
from mkt.plotting import CONTRAST, draw_histogram, draw_kernels, draw_map, draw_region, draw_surface, show_frame
from mkt.regions import displaced, warp
from mkt.scenes import Layer, Scene, sequence
from mkt.textures import OBJECTS

SPACES = ["hsv", "rgb", "hs"]
WIDTH = 96.0  # of the object [px]; ours, the paper does not say
MIDDLE = 159.5, 119.5  # of the image, between two pixels: the edges of an object of even width fall between pixels too


def still(texture, seed=0):
    """Two frames of an object that stands still before the workshop: only the sensor noise differs."""
    return sequence(Scene(Layer(texture, WIDTH, ((0.0, *MIDDLE, 0.0, 1.0),)), length=2, seed=seed))


def pulled_back(frame, region, kernels, n=160):
    """The object in its own frame, f_x: an upright picture (n / aspect, n, 3) of the region, nearest pixels."""
    nx, ny = n, round(n / kernels.aspect)
    x, y = np.meshgrid((2 * np.arange(nx) + 1) / nx - 1, (2 * np.arange(ny) + 1) / ny - 1)
    columns, rows = np.rint(warp(region, np.stack([x.ravel(), y.ravel()], -1))).astype(int).T
    return frame[rows.clip(0, len(frame) - 1), columns.clip(0, frame.shape[1] - 1)].reshape(ny, nx, 3)


def object_plane(kernels):
    """Left, right, bottom, top of the object in the object plane, as ``imshow(extent=...)`` wants it."""
    x, y = kernels.half_sides
    return -x, x, y, -y


def weight_maps(kernels, n=120):
    """Each kernel's weights over the whole object, as pictures (J, ny, n)."""
    nx, ny = n, round(n / kernels.aspect)
    x, y = np.meshgrid((2 * np.arange(nx) + 1) / nx - 1, (2 * np.arange(ny) + 1) / ny - 1)
    return kernels.weigh(np.stack([x.ravel(), y.ravel()], -1) * kernels.half_sides).reshape(-1, ny, nx)


@figure("teuliere2009.fig1", size=(10, 3.6), profile=list(PROFILES), span=(0.4, 1.0, 0.1), bins=SPACES, object=list(OBJECTS))
def fig1(canvas, *, profile="epanechnikov", span=1.0, bins="hsv", object="car"):
    """A kernel-weighted colour histogram.

    The printed figure 1 is lost with its page, so this is not a reproduction of it.  Left, a rendered frame with the object's region;
    middle, the object pulled back into its own frame by the deformation f_x of equation (1), dimmed where the kernel gives no weight;
    right, its histogram, equation (2), each bar in the mean colour of its bin.
    """
    scene, bins = still(object), ColorBins(bins)
    region, frame = scene.truth[0], scene.frames[0]
    kernels = Kernels("one", profile, span).fitted(region)
    q = histograms(bins(frame), bins.m, kernels, region)[0, 0]

    left, middle, right = canvas.subplots(1, 3, width_ratios=(1.15, 1, 1.8), gridspec_kw={"left": 0.01, "bottom": 0.15, "wspace": 0.25})
    show_frame(left, frame, "frame and region")
    draw_region(left, region)
    weight = weight_maps(kernels, 160)[0]
    dimmed = pulled_back(frame, region, kernels) * (0.25 + 0.75 * weight / weight.max())[..., None]
    show_frame(middle, dimmed.astype(np.uint8), "pulled back and weighted")
    draw_histogram(right, q, bins, title=f"{np.count_nonzero(q)} of {bins.m} bins filled")
    return {"sum": float(q.sum()), "filled": int(np.count_nonzero(q))}


@figure("teuliere2009.fig2", size=(10, 4.2), layout=["one", "2x2", "3x3", "4x4", "tiles"], span=(0.4, 1.4, 0.1), profile=list(PROFILES),
        object=list(OBJECTS))
def fig2(canvas, *, layout="3x3", span=1.0, profile="epanechnikov", object="car"):
    """The multiple-kernel configuration.

    Left, centres and supports of the kernels over the object; right, the weight that each kernel gives to each place, white being none.
    The paper draws nine kernels without saying where they end: here they stay inside the object, neighbours half a radius apart along its
    shorter side.  Tiles are the nine parts of the particle filter, which have constant weight.
    """
    scene = still(object)
    region, frame = scene.truth[0], scene.frames[0]
    profile = "uniform" if layout == "tiles" else profile
    kernels = Kernels(layout, profile, span).fitted(region)
    maps = weight_maps(kernels)
    side = round(len(maps) ** 0.5)
    ax = canvas.add_axes((0.01, 0.02, 0.46, 0.88))
    ax.imshow(pulled_back(frame, region, kernels), extent=object_plane(kernels))
    draw_kernels(ax, kernels)
    ax.set(xticks=[], yticks=[], title=f"{len(kernels.centres)} kernels, {profile}")
    panels = canvas.subplots(side, side, squeeze=False, gridspec_kw={"left": 0.5, "right": 0.99, "bottom": 0.03, "top": 0.97, "wspace": 0.05, "hspace": 0.05})
    for panel, weights in zip(panels.ravel(), maps):
        panel.imshow(weights, cmap="Blues", vmin=0, vmax=1, extent=object_plane(kernels))
        panel.set(xticks=[], yticks=[])
        panel.spines[:].set(visible=True, color="0.6")
    return {"kernels": len(maps), "covered": float((maps > 0).any(0).mean())}


def cost_surfaces(layout, span, bins, object, extent, seed=0):
    """What figure 3 draws: the distance for one kernel and for a layout, over 61 x 61 displacements and rotations.

    Returns x (61,) [px], theta (61,) [rad] and the two surfaces (61, 61), rotation down, x across.
    """
    scene, bins = still(object, seed), ColorBins(bins)
    learnt, seen = (bins(frame) for frame in scene.frames)
    x, theta = np.linspace(-extent, extent, 61), np.deg2rad(np.linspace(-60, 60, 61))
    grid = displaced(scene.truth[0], x, 0, theta[:, None])
    kernels = [Kernels(name, span=min(span, 1.0) if name == "one" else span, samples=2400) for name in ("one", layout)]
    return x, theta, [learn(learnt, scene.truth[0], bins, k).distances(seen, grid) for k in kernels]


@figure("teuliere2009.fig3", size=(10, 6.2), layout=["one", "2x2", "3x3", "4x4"], span=(0.4, 1.4, 0.1), bins=SPACES, object=list(OBJECTS),
        extent=(10, 40, 5))
def fig3(canvas, *, layout="3x3", span=1.0, bins="hsv", object="car", extent=20, seed=0):
    """The distance over rotation and x location, for one kernel (a) and for several (b).

    Above, the two surfaces over the same axes; below, their cut along rotation through the true place.  The object is learnt in one
    rendered frame and looked for in the next, which differs by its sensor noise.  One centred round kernel sees the same
    histogram whatever the angle: its valley is flat, and only several kernels make a pit.  A single kernel cannot grow beyond the object:
    above a span of 1 only (b) changes.
    """
    x, theta, surfaces = cost_surfaces(layout, span, bins, object, extent, seed)
    degrees = np.rad2deg(theta)
    titles = ("(a) one kernel", f"(b) {layout} kernels" if layout != "one" else "(b) one kernel again")
    for place, z, title in zip(((-0.02, 0.33, 0.54, 0.63), (0.46, 0.33, 0.54, 0.63)), surfaces, titles):
        ax = canvas.add_axes(place, projection="3d")
        draw_surface(ax, x, degrees, z, (0, 0.9), title=title, xlabel="x [px]", ylabel="rotation [deg]", zlabel="distance")
    cut = canvas.add_axes((0.08, 0.09, 0.88, 0.23))
    for z, title, color in zip(surfaces, titles, reversed(CONTRAST[:2])):
        cut.plot(degrees, z[:, 30], color=color, label=title, lw=2)
    cut.set(xlabel="rotation at the true place [deg]", ylabel="distance", ylim=(0, 0.7), xlim=(-60, 60), xticks=range(-60, 61, 20))
    cut.legend(loc="upper center", ncols=2)
    return {"one": surfaces[0], "several": surfaces[1], "x": x, "theta": theta}


@figure("teuliere2009.fig4", size=(10, 6), grid=("exposure", "speed"), exposure=(0.0, 1.0, 0.1), speed=(0, 40, 4), layout=["one", "2x2", "3x3", "4x4"], object=list(OBJECTS))
def fig4(canvas, *, exposure=0.8, speed=24, layout="3x3", object="car", seed=0):
    """Blurring due to fast motion.

    Above, the object standing still and the same object crossing the same place while the shutter is open: the frame is the mean of
    sub-frame renders over the exposure.  Below, the distance to the still object over rotation and x location in either frame, its
    lowest point marked.  Speed and exposure are ours; the paper prints one blurred frame.
    """
    sharp, blurred = still(object, seed), sequence(_crossing(object, exposure, float(speed), seed + 1))
    bins, x, theta = ColorBins(), np.linspace(-30, 30, 41), np.deg2rad(np.linspace(-60, 60, 41))
    target = learn(bins(sharp.frames[0]), sharp.truth[0], bins, Kernels(layout))
    frames = sharp.frames[1], blurred.frames[1]
    grid = displaced(sharp.truth[0], x, 0, theta[:, None])
    surfaces = [target.distances(bins(frame), grid) for frame in frames]

    places = {"right": 0.88, "bottom": 0.09, "top": 0.95}
    axes, degrees = canvas.subplots(2, 2, height_ratios=(1.15, 1), gridspec_kw=places), np.rad2deg(theta)
    for ax, frame, title in zip(axes[0], frames, ("standing still", f"{speed} px a frame, shutter open for {exposure:g} of it")):
        show_frame(ax, frame, title)
        draw_region(ax, sharp.truth[0])
        ax.set(xlim=(80, 240), ylim=(170, 70))
    for ax, z in zip(axes[1], surfaces):
        mesh = draw_map(ax, x, degrees, z, (0, 0.9), xlabel="x [px]", ylabel="rotation [deg]", title=f"distance at the truth {z[20, 20]:.2f}")
    canvas.colorbar(mesh, cax=canvas.add_axes((0.905, 0.09, 0.015, 0.36)), label="distance")
    return {"sharp": surfaces[0], "blurred": surfaces[1], "x": x, "theta": theta}


def _crossing(texture, exposure, speed, seed):
    """An object that is at the middle of the image in frame 1, moving along x at a constant speed [px a frame]."""
    path = ((0.0, MIDDLE[0] - speed, MIDDLE[1], 0.0, 1.0), (2.0, MIDDLE[0] + speed, MIDDLE[1], 0.0, 1.0))
    return Scene(Layer(texture, WIDTH, path), length=2, shutter=exposure, seed=seed)
