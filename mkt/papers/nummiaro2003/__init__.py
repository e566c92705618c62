"""[N03]: K. Nummiaro, E. Koller-Meier, L. Van Gool, 2003.

Figure 1 is in `mkt.papers.nummiaro2003.listing`, 2 and 3 are in
`mkt.papers.nummiaro2003.steps`, 5 in `mkt.papers.nummiaro2003.costs`, 4 and 10 in
`mkt.papers.nummiaro2003.sequences`, 6 and 7 in `mkt.papers.nummiaro2003.losing`, 8 and
9 in `mkt.papers.nummiaro2003.learning`, and two runs as
`mkt.papers.nummiaro2003.films`; what is claimed is in `mkt.papers.nummiaro2003.claims`.
"""
