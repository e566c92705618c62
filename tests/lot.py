"""What is too much for every run is tested by lot, another part each day.

MKT_TEST_DAY repeats a day: what failed then fails again.  Four days on end, such as 0,
1, 2 and 3, see every chapter and figure both ways; right answers to labs take seven,
empty ones two, and the chapters' own answers too.
"""

import datetime
import os

DAY = int(os.environ.get("MKT_TEST_DAY") or datetime.date.today().toordinal())
