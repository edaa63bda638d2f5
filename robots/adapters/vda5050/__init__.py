"""VDA 5050, versions 2 and 3: vehicles as robots of Macta, and robots as vehicles of another master control."""
