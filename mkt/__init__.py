"""Multiple kernel tracking: colour-histogram trackers of three papers, small enough to read in an afternoon.

Read in this order: `mkt.regions`, `mkt.kernels`, `mkt.histograms`, `mkt.tracking`; then the material to track, `mkt.scenes` and
`mkt.datasets`; the trackers, `mkt.trackers.ssd` and `mkt.trackers.particle_filter` first; then how they are judged and drawn,
`mkt.evaluation`, `mkt.plotting`, `mkt.figures`, over many runs in `mkt.sweeps` and sentence by sentence in `mkt.claims`.  A robot that follows
what is tracked: `mkt.servo`, `mkt.kalman`, `mkt.robot`, `mkt.loop`.  The course: `mkt.widgets`, `mkt.workbench`, `mkt.labs`, `mkt.book`.

References
----------
[T09] C. Teulière, E. Marchand, L. Eck: A combination of particle filtering and deterministic approaches for multiple kernel
tracking.  ICRA 2009.

[N03] K. Nummiaro, E. Koller-Meier, L. Van Gool: Color features for tracking non-rigid objects.  Acta Automatica Sinica, 2003.

[C14] D. A. L. Córdoba, C. M. C. C. Koike, F. de Barros Vidal: Particle filter and visual tracking: a hybrid resampling approach to
improving robustness in cluttered and occluded environments.  2014.
"""
# Nothing is imported here: ``python3 -m mkt`` runs this file before numpy is installed.

__version__ = "0.1.0"
