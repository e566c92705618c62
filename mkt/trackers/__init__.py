"""One tracker a file: frozen dataclasses with ``init`` and ``step``; and their parts.

The protocol is `mkt.tracking.Tracker`; `mkt.trackers.by_name` has those of commands and
tables by name.
"""
