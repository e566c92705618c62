"""One tracker a file: frozen dataclasses with ``init`` and ``step``.

The protocol is `mkt.tracking.Tracker`; `mkt.trackers.by_name` has them by name.
"""
