"""The interference experiment (P-SMPA §6): a robot goes to the kitchen door while somebody puts things in its way.

`corridor` is the world, `interferer` who puts obstacles there, `trial` one run of the behavioural agent, `table` all
rows of table 1 over many seeds, `plots` figures like 5 and 6.
"""
