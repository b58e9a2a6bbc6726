/* The same as step.c, of the loop that has four vectors and more at different stages: of four (KELLY_VECTORS), a lane each. A slice is enough:
 * what a vector computes is what one alone does. */
#include "step.c"
