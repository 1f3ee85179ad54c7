"""`python -m pneumatic_servo`: the command line, where its program is not on the path."""

import sys

from pneumatic_servo.cli import main

sys.exit(main())
