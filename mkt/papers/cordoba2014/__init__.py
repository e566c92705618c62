"""[C14]: D. A. L. Córdoba, C. M. C. C. Koike, F. de Barros Vidal, 2014."""
