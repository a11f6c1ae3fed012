"""What can be wrong with the ends, the loads and the length of a quasi-static line; 0 is fine."""

NEUTRAL_SLACK = 1

TEXT = {
    NEUTRAL_SLACK: "a slack line without weight in still water has no definite shape; "
    "give a weight, a current, a tow velocity or less length",
}
