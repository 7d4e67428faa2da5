/* Methods of a run.

   From rodgen.model.methods by tests/tableaux.py (`make docs NAME=reference`);
   tests/reference.py guards it. Do not edit. */

enum {
    RODGEN_EULER = 0,
    RODGEN_SEMI_IMPLICIT_EULER = 1,
    RODGEN_RK4 = 2,
    RODGEN_THESIS_RUNGE_KUTTA = 3,
    RODGEN_DOP853 = 4,
    RODGEN_GAUSS = 5,
    RODGEN_RADAU = 6,
    RODGEN_GAUSS_EQUAL_STEPS = 7,
    RODGEN_METHODS = 8 /* how many there are */
};
