"""What can be wrong with the ends, the loads and the length of a quasi-static line; 0 is fine."""

NEUTRAL_SLACK = 1
TOO_SOFT = 2

TEXT = {
    NEUTRAL_SLACK: "a slack line without weight in still water has no definite shape; "
    "give a weight, a current, a tow velocity or less length",
    TOO_SOFT: "no balance was found of a line that its load stretches by more than its length; "
    "give a greater axial_stiffness",
}
