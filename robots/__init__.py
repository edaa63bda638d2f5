"""The behavioural agents: on-robot software, and the contract between robots and the service.

`wire` (scripts, messages), `link`, `physical.body`, `clock` and `world` are the contract; all else runs on a robot.
Imports no other package of ours. `sim` and `app` may import it.
"""
