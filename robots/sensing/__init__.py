"""Parallel sensing (P-SMPA): sensor actions beside the actuator actions that need their percepts, and only then.

`actions` has the formal model, `plans` makes a plan of a script, `machine` schedules it (algorithm 2), `controller`
runs the sensor actions and keeps their data stores (algorithm 3), `loops` are the control loops to choose from
(algorithm 1, and sequential SMPA for comparison), `energy` counts what sensing costs and what it saves.

Below them are the activities of SRA: a `cascade` of modules, after the drivers of the sensors, such as virtual `sonar`.
"""
