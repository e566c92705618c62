"""[C14]: D. A. L. Córdoba, C. M. C. C. Koike, F. de Barros Vidal, 2014.

Figures 1 to 6 are in `mkt.papers.cordoba2014.tracking`, the cost of resampling in
`mkt.papers.cordoba2014.resampling`, Table 1 in `mkt.papers.cordoba2014.table`, with
the numbers of the paper in `mkt.papers.cordoba2014.printed`, and a run as
`mkt.papers.cordoba2014.film`.  What is claimed is in `mkt.papers.cordoba2014.claims`;
`mkt.papers.cordoba2014.looks` and `mkt.papers.cordoba2014.ablation` take the filter
apart.
"""
