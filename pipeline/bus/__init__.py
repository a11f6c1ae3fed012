"""How the conductor and the hosts of a distributed run talk to each other."""
