"""What is too much for every run is tested by lot, another part each day."""

import datetime

DAY = datetime.date.today().toordinal()
