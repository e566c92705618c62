"""[N03]: K. Nummiaro, E. Koller-Meier, L. Van Gool, 2003."""
