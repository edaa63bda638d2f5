"""How long a robot bears what goes wrong before it does something about it. All of it our choice; what comes of it in
each case: docs/decisions/not-getting-stuck.md.
"""

FAULT_S = 5.0
"""A sensor it cannot do without may fail for this long, the robot standing still, before the script is given up."""
LOST_S = 1.0
"""A maintained condition may flicker for this long before its loss is believed."""
UNSEEN_S = 20.0
"""What it must see to go on may be out of view this long, its place with it, before the packet is given up."""
STALLED_S = 7.0
"""A packet that comes no nearer to its goal for this long has stalled: the robot backs off, turns and tries again."""
RETRIES = 4
"""How often, unless the packet says otherwise, before the packet is given up."""
