"""What is drawn and claimed: a folder for each paper, and the lessons between.

They are `mkt.papers.teuliere2009`, `mkt.papers.nummiaro2003` and
`mkt.papers.cordoba2014`; `mkt.papers.lessons` has what no paper printed.
"""
