"""The behavioural agents: on-robot software, and the contract between robots and the service.

`wire` (scripts, messages), `link`, `body`, `clock` and `world` are the contract; everything else runs on a robot.
Imports nothing of ours. `sim` and `app` may import it.
"""
