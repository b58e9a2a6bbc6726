/* one_test.c - main of an image with one test, for parts whose flash does not hold all: -DONE_TEST=test_NAME. */
#include "check.h"

void ONE_TEST(void);
int main(void);

int main(void)
{
    ONE_TEST();
    check_decimal(check_passed);
    check_text(" passed, ");
    check_decimal(check_failed);
    check_text(" failed\n");
    return check_failed != 0;
}
