"""Multiple kernel tracking: colour-histogram trackers of three papers.

What to read first, two or three days in all, is *the method*, seven files, and after it
the three trackers of [T09], on which all others are variations:

1. `mkt.regions`, the one currency: oriented rectangles in an image;
2. `mkt.colors`, from a frame to an image of bins;
3. `mkt.kernels`, where an object is looked at, and with what weight;
4. `mkt.histograms`, what is seen there, and how alike two looks are;
5. `mkt.particles`, motion models and resampling;
6. `mkt.tracking`, what a tracker is, and the loop;
7. `mkt.evaluation`, how well a track fits the truth;

beside them `mkt.homographies`, planes in space, `mkt.edges`, another image of bins, and
for the wishes of [N03] `mkt.neighbours`, `mkt.silhouettes` and `mkt.autoregression`;

then `mkt.trackers.ssd` with the steps of `mkt.trackers.newton`,
`mkt.trackers.particle_filter`, `mkt.trackers.combined` [T09],
`mkt.trackers.adaptive` with `mkt.trackers.ellipses`, `mkt.trackers.appearance` and
`mkt.trackers.detector` [N03], `mkt.trackers.hybrid_resampling` and
`mkt.trackers.template_matching` [C14], `mkt.trackers.guided` with
`mkt.trackers.search`, `mkt.trackers.gains`, `mkt.trackers.close_up` and
`mkt.trackers.last_word` (ours), `mkt.trackers.neighbours`,
`mkt.trackers.shaped` and `mkt.trackers.two_cameras` (wishes of [N03]),
`mkt.trackers.opencv` (rivals),
`mkt.trackers.scaled`, which is any of them on smaller frames, and
`mkt.trackers.by_name`, those of commands and tables; on planes in space
`mkt.trackers.homography`, `mkt.trackers.homography_combined`, and the rival
`mkt.trackers.homography_esm`.

The rest of the house, from the ground up; a wing knows only those below it:

=================  =================================================================
the method         see above, and `mkt.plotting`, `mkt.checks`, `mkt.files`,
                   `mkt.registry`, `mkt.types`
`mkt.trackers`     see above
`mkt.scenes`       made of `~mkt.scenes.textures`, which are photographs
                   (`~mkt.scenes.photographs`) or painted
                   (`~mkt.scenes.painting`, `~mkt.scenes.objects`,
                   `~mkt.scenes.grounds`), in `~mkt.scenes.layers` on
                   `~mkt.scenes.paths`, by `~mkt.scenes.rendering`;
                   `~mkt.scenes.questions`,
                   `~mkt.scenes.teuliere2009`, `~mkt.scenes.nummiaro2003`,
                   `~mkt.scenes.cordoba2014`; `~mkt.scenes.drawn` by lot,
                   `~mkt.scenes.varied`, `~mkt.scenes.two_cameras`,
                   `~mkt.scenes.cards` in space
`mkt.sequences`    `~mkt.sequences.video` in, `~mkt.sequences.writing` out,
                   `~mkt.sequences.quiet`, `~mkt.sequences.tracks` as text,
                   `~mkt.sequences.truth_formats` and `~mkt.sequences.mot`, from
                   `~mkt.sequences.rows` to a `~mkt.sequences.truth`;
                   `~mkt.sequences.benchmarks`, `~mkt.sequences.parts` of them,
                   `~mkt.sequences.carphone`
`mkt.servoing`     `~mkt.servoing.features`, `~mkt.servoing.law`,
                   `~mkt.servoing.self_motion`, `~mkt.servoing.poles`,
                   `~mkt.servoing.robot`, `~mkt.servoing.controller`,
                   `~mkt.servoing.loop`,
                   `~mkt.servoing.planes`
`mkt.experiments`  `~mkt.experiments.sweep`, `~mkt.experiments.cache`,
                   `~mkt.experiments.dependencies`, `~mkt.experiments.processes`,
                   `~mkt.experiments.statistics`, `~mkt.experiments.timing`,
                   `~mkt.experiments.claims`, `~mkt.experiments.claims_as_text`,
                   `~mkt.experiments.leaderboard`,
                   `~mkt.experiments.leaderboard_as_text`; `~mkt.experiments.shipped`,
                   what was run for the release
`mkt.figures`      `~mkt.figures.registry`, `~mkt.figures.panel`,
                   `~mkt.figures.captions`, `~mkt.figures.tooltips`,
                   `~mkt.figures.static_panel`, `~mkt.figures.live`,
                   `~mkt.figures.live_panel`, `~mkt.figures.pictures`,
                   `~mkt.figures.export`, `~mkt.figures.light_pdf`,
                   `~mkt.figures.film`
`mkt.papers`       what is drawn and claimed, a folder for each paper, and
                   `~mkt.papers.lessons`;
                   `~mkt.papers.runs` keeps the runs, `~mkt.papers.live` has what
                   live figures are given
`mkt.own_video`    `~mkt.own_video.typed_box`, `~mkt.own_video.settings`,
                   `~mkt.own_video.recording`,
                   `~mkt.own_video.overlay`, `~mkt.own_video.webcam`,
                   `~mkt.own_video.workbench`, `~mkt.own_video.controls`,
                   `~mkt.own_video.box_picker`, `~mkt.own_video.static`
`mkt.course`       `~mkt.course.cli`, its `~mkt.course.commands`,
                   `~mkt.course.environment`,
                   `~mkt.course.doctor`, `~mkt.course.speed`, `~mkt.course.stripping`,
                   `~mkt.course.slides`,
                   `~mkt.course.figure_arguments`, `~mkt.course.own_tracker`,
                   `~mkt.course.book`, `~mkt.course.labs`
=================  =================================================================

A wing of many files says in its own ``__init__`` what is in each.  ``mkt/live`` is what
computes in the pages of the book, in JavaScript: its tests hold it to the library.

The names that a notebook needs are here too, loaded when they are first used:
``import mkt``, then ``mkt.track(mkt.SSD(), mkt.carphone())``.

References
----------
[T09] C. Teulière, E. Marchand, L. Eck: A combination of particle filtering and
deterministic approaches for multiple kernel tracking.  ICRA 2009.

[N03] K. Nummiaro, E. Koller-Meier, L. Van Gool: Color features for tracking non-rigid
objects.  Acta Automatica Sinica, 2003.

[C14] D. A. L. Córdoba, C. M. C. C. Koike, F. de Barros Vidal: Particle filter and
visual tracking: a hybrid resampling approach to improving robustness in cluttered and
occluded environments.  2014.
"""

# Nothing is imported here but the machinery of imports: ``python3 -m mkt`` runs this
# file before numpy is installed.
import importlib
import time

__version__ = "0.2.0"
BEGUN = time.time()  # code that is written later is not what runs

_PUBLIC = {
    "mkt.autoregression": "AutoRegression",
    "mkt.checks": "checked_frame checked_region",
    "mkt.colors": "BinImage ColorBins Joined JointHSV",
    "mkt.edges": "EdgeBins",
    "mkt.evaluation": (
        "accuracy errors evaluate overlap overlaps restarted robustness scored_frames "
        "success true_positives"
    ),
    "mkt.experiments.claims": "judge measure",
    "mkt.experiments.shipped": "verdicts",
    "mkt.experiments.statistics": (
        "FRACTION MEAN MEDIAN PAIRS SHARE interval p_value summaries"
    ),
    "mkt.experiments.sweep": "Job jobs sweep write_table",
    "mkt.figures": "explore show",
    "mkt.figures.film": "play",
    "mkt.figures.registry": "FIGURES figure shown",
    "mkt.files": "DataError",
    "mkt.histograms": "Target coefficient distance learn log_likelihood",
    "mkt.kernels": "Kernels",
    "mkt.neighbours": "MEASURES SoftBins circular_emd smoothing",
    "mkt.own_video.overlay": "annotated",
    "mkt.own_video.recording": "record",
    "mkt.own_video.settings": "Settings settled",
    "mkt.own_video.workbench": "workbench",
    "mkt.particles": (
        "EllipseMotion Motion Particles SCHEMES effective_sample_size mean_region "
        "multinomial normalised residual stratified systematic"
    ),
    "mkt.plotting": (
        "bin_colors draw_box draw_ellipse draw_histogram draw_kernels draw_map "
        "draw_region draw_surface draw_tracked draw_truth film_strip plot_track "
        "show_frame use_style"
    ),
    "mkt.regions": "corners displaced from_box to_box unwarp warp wrap_angle",
    "mkt.scenes": "SCENES",
    "mkt.scenes.drawn": "Drawn drawn",
    "mkt.scenes.layers": "Layer",
    "mkt.scenes.rendering": "Scene",
    "mkt.sequences.carphone": "Carphone carphone",
    "mkt.sequences.mot": "mot",
    "mkt.sequences.truth_formats": "bobot otb video vot",
    "mkt.servoing.features": "Camera error features interaction_matrix moments",
    "mkt.servoing.law": "AdaptiveGain twist",
    "mkt.servoing.controller": "Servo",
    "mkt.servoing.loop": "Experiment close_loop",
    "mkt.servoing.poles": "closed_loop",
    "mkt.servoing.robot": "Workspace move",
    "mkt.servoing.self_motion": "OFF Kalman",
    "mkt.silhouettes": "Silhouette by_colour grabbed",
    "mkt.trackers.adaptive": "Adaptive",
    "mkt.trackers.by_name": "LABELS TRACKERS with_particles",
    "mkt.trackers.combined": "Combined",
    "mkt.trackers.detector": "moving",
    "mkt.trackers.guided": "Guided",
    "mkt.trackers.homography": "PlaneSSD",
    "mkt.trackers.homography_combined": "PlaneCombined",
    "mkt.trackers.homography_esm": "PlaneESM",
    "mkt.trackers.hybrid_resampling": "HybridResampling",
    "mkt.trackers.neighbours": "CrossBin",
    "mkt.trackers.newton": "Prior differentiate minimise moved newton_step",
    "mkt.trackers.opencv": "MIL CamShift MeanShift",
    "mkt.trackers.particle_filter": "ParticleFilter",
    "mkt.trackers.shaped": "Shaped",
    "mkt.trackers.ssd": "SSD",
    "mkt.trackers.template_matching": "TemplateMatching",
    "mkt.tracking": "Sequence Track Tracker follow report track",
}
NAMES = {name: module for module, names in _PUBLIC.items() for name in names.split()}


def __getattr__(name):
    """A public name, or a module or wing of the package, loaded now (PEP 562)."""
    if name in NAMES:
        value = getattr(importlib.import_module(NAMES[name]), name)
    else:
        try:
            value = importlib.import_module(f"{__name__}.{name}")
        except ModuleNotFoundError as error:
            if error.name != f"{__name__}.{name}":
                raise  # a package that the module needs is missing
            message = f"module {__name__!r} has no attribute {name!r}"
            raise AttributeError(message) from None
    globals()[name] = value
    return value


def __dir__():
    """What can be completed: all public names, loaded or not, and loaded modules."""
    return sorted({*globals(), *NAMES} - {"importlib", "time", "BEGUN", "NAMES"})
