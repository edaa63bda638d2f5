"""Goals: a small grammar of sentences, and checks of goals against a world and what is believed of it.

`grammar` and `check` are pure; `desk` records goals and hands them to the planner.
"""
