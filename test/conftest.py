"""What all tests need."""

import signal

# Where tests run under nohup, or as a service, hangups are ignored, and whatever they start would
# ignore them as well: what a process does when its terminal closes could not be tested.
signal.signal(signal.SIGHUP, signal.SIG_DFL)
