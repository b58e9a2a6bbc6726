/* The same as step.c, of the loop that has four vectors and more at different stages: of four (KELLY_VECTORS), a lane each. */
#include "step.c"
