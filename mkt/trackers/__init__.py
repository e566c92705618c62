"""One tracker a file, each a frozen dataclass with ``init`` and ``step`` (`mkt.tracking.Tracker`)."""
