from taskbuilder.description import Above, Bonus, Description


class Good(Description):
    success = Above("cube", height=0.2)
    reward = (Bonus("done", success, 1.0),)
