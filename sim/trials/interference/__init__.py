"""The interference experiment (P-SMPA §6): a robot goes to the kitchen door while obstacles are put in its way.

`corridor` is the world, `interferer` places the obstacles, `trial` is one run of the behavioural agent, `table` all
rows of table 1 over many seeds, `plots` draws figures like 5 and 6.
"""
