"""[T09]: C. Teulière, E. Marchand, L. Eck, 2009.

Figures 1 to 4 are in `mkt.papers.teuliere2009.histograms`, 5 to 7 in
`mkt.papers.teuliere2009.tracking`, 8 to 11 in `mkt.papers.teuliere2009.servoing`, of
which `mkt.papers.teuliere2009.film` makes a film; what is claimed is in
`mkt.papers.teuliere2009.claims`.
"""
