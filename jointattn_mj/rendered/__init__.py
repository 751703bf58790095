"""The mechanism of chapter 5 in the rendered world: the same mind, whose sensations come from pictures."""
