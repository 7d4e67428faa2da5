/* Sums of stages, written out for each count of them, so that they take one pass over the states. The file that includes
   this defines CASE(count, value): the case of a sum of so many products, and how its value is used. */

#ifndef RODGEN_SUMS_H
#define RODGEN_SUMS_H

#define PRODUCT_0 0.0
#define PRODUCT_1 c[0] * k0[i]
#define PRODUCT_2 PRODUCT_1 + c[1] * k1[i]
#define PRODUCT_3 PRODUCT_2 + c[2] * k2[i]
#define PRODUCT_4 PRODUCT_3 + c[3] * k3[i]
#define PRODUCT_5 PRODUCT_4 + c[4] * k4[i]
#define PRODUCT_6 PRODUCT_5 + c[5] * k5[i]
#define PRODUCT_7 PRODUCT_6 + c[6] * k6[i]
#define PRODUCT_8 PRODUCT_7 + c[7] * k7[i]
#define PRODUCT_9 PRODUCT_8 + c[8] * k8[i]
#define PRODUCT_10 PRODUCT_9 + c[9] * k9[i]
#define PRODUCT_11 PRODUCT_10 + c[10] * k10[i]
#define PRODUCT_12 PRODUCT_11 + c[11] * k11[i]
#define STAGE(number) const double *const restrict k##number = k[sum->at[number < sum->count ? number : 0]]
#define CASES(value) \
    switch (sum->count) { \
        CASE(0, value) \
        CASE(1, value) \
        CASE(2, value) \
        CASE(3, value) \
        CASE(4, value) \
        CASE(5, value) \
        CASE(6, value) \
        CASE(7, value) \
        CASE(8, value) \
        CASE(9, value) \
        CASE(10, value) \
        CASE(11, value) \
        CASE(12, value) \
    }
#define STAGES_OF_SUM \
    const double *const restrict c = sum->value; \
    STAGE(0); \
    STAGE(1); \
    STAGE(2); \
    STAGE(3); \
    STAGE(4); \
    STAGE(5); \
    STAGE(6); \
    STAGE(7); \
    STAGE(8); \
    STAGE(9); \
    STAGE(10); \
    STAGE(11)

#endif
