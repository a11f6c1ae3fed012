"""What can be wrong with the ends, the load and the length of a static line; 0 is fine."""

TOO_SHORT = 1
TAUT = 2
NEUTRAL_SLACK = 3
END_BELOW_SEABED = 4
NOT_CONVERGED = 5
NO_ANCHOR = 6

TEXT = {
    TOO_SHORT: "the ends are farther apart than the inextensible line is long; give more length or an axial stiffness",
    TAUT: "the ends are exactly as far apart as the inextensible line is long, so its tension has no bound; "
    "give more length or an axial stiffness",
    NEUTRAL_SLACK: "a slack line without weight in water or other load has no definite shape; "
    "give a weight or less length",
    END_BELOW_SEABED: "an end lies below the seabed; raise the end or give a deeper seabed",
    NOT_CONVERGED: "the static line did not converge; please report its length, load, stiffness and ends",
    NO_ANCHOR: "with both ends above the seabed its friction depends on how the line was laid; "
    "put one end on the seabed, or set the friction to 0",
}
