"""Stage 4, islands: the graph of bodies and contacts is coloured, so that contacts of one colour share no moving body."""
