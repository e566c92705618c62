"""[T09]: C. Teulière, E. Marchand, L. Eck, 2009."""
