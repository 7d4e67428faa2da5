/* Calls of XLA to the functions of generated modules, through its foreign function interface.

The arguments of every call are t (...), y (..., states) and p (..., parameters), doubles; the dots
stand for axes of vmap, each of which an argument may have with one entry for all. The attribute
`model` says whose functions are called: it is no address, so that a program that XLA has kept for
another process is refused instead of jumping anywhere. */

#include <math.h>
#include <stdlib.h>

#include "xla_ffi.h"

typedef void rates(double t, const double *y, const double *p, double *out);
typedef void batch(size_t count, double t, const double *y, const double *p, size_t stride,
                   double *out);

typedef struct {
    int64_t key, states, width, timed;
    rates *rhs, *jac;
    batch *rhs_batch;
} model;

enum { MODELS = 4096 };
static model models[MODELS];
static size_t known = 0;

/* Make a model known by its key: whether there was room. */
int rodgen_jax_add(int64_t key, int64_t states, int64_t width, int64_t timed, size_t rhs,
                   size_t jac, size_t rhs_batch)
{
    if (known == MODELS)
        return 0;
    models[known] = (model){key, states, width, timed, (rates *)rhs, (rates *)jac,
                            (batch *)rhs_batch};
    known++;
    return 1;
}

typedef struct {
    const model *of;
    const XLA_FFI_Buffer *t, *y, *p;
    int64_t axes, rows;
    const int64_t *dims;
    double *out;
} call;

static XLA_FFI_Error *refused(const XLA_FFI_CallFrame *frame, const char *message)
{
    XLA_FFI_Error_Create_Args how = {XLA_FFI_Error_Create_Args_STRUCT_SIZE, NULL, message,
                                     XLA_FFI_Error_Code_INVALID_ARGUMENT};
    return frame->api->XLA_FFI_Error_Create(&how);
}

/* Whether XLA only asks what it is about to call; then it is told. */
static int asked(const XLA_FFI_CallFrame *frame)
{
    if (frame->extension_start && frame->extension_start->type == XLA_FFI_Extension_Metadata) {
        XLA_FFI_Metadata *told = ((XLA_FFI_Metadata_Extension *)frame->extension_start)->metadata;
        told->api_version.major_version = XLA_FFI_API_MAJOR;
        told->api_version.minor_version = XLA_FFI_API_MINOR;
        told->traits = 0;
        return 1;
    }
    return frame->stage != XLA_FFI_ExecutionStage_EXECUTE;
}

static const model *model_of(const XLA_FFI_CallFrame *frame)
{
    if (frame->attrs.size != 1 || frame->attrs.types[0] != XLA_FFI_AttrType_SCALAR)
        return NULL;
    int64_t key = *(int64_t *)((XLA_FFI_Scalar *)frame->attrs.attrs[0])->value;
    for (size_t i = known; i-- > 0;)
        if (models[i].key == key)
            return &models[i];
    return NULL;
}

/* Whether an argument has doubles over the axes of the call, each of them or one for all, and
   count (0 for a number) beside these. */
static int fits(const XLA_FFI_Buffer *array, const call *c, int64_t count)
{
    if (array->dtype != XLA_FFI_DataType_F64 || array->rank != c->axes + (count != 0))
        return 0;
    for (int64_t i = 0; i < c->axes; i++)
        if (array->dims[i] != 1 && array->dims[i] != c->dims[i])
            return 0;
    return !count || array->dims[c->axes] == count;
}

/* The call of a frame, whose result has so many axes for every row. */
static const char *read_call(const XLA_FFI_CallFrame *frame, int64_t inner, call *c)
{
    if (!(c->of = model_of(frame)))
        return "a model that this process does not know: make it with rodgen.jax.rhs";
    if (frame->args.size != 3 || frame->rets.size != 1)
        return "three arguments and one result are due";
    const XLA_FFI_Buffer *result = frame->rets.rets[0];
    c->t = frame->args.args[0], c->y = frame->args.args[1], c->p = frame->args.args[2];
    c->axes = result->rank - inner;
    c->dims = result->dims;
    c->out = result->data;
    c->rows = 1;
    for (int64_t i = 0; i < c->axes; i++)
        c->rows *= c->dims[i];
    if (result->dtype != XLA_FFI_DataType_F64 || c->axes < 0 || !fits(c->t, c, 0)
        || !fits(c->y, c, c->of->states) || !fits(c->p, c, c->of->width))
        return "doubles t (), y (states,) and p (parameters,) are due";
    return NULL;
}

/* What an argument has of a row, count numbers. */
static const double *row_of(const XLA_FFI_Buffer *array, const call *c, int64_t row, int64_t count)
{
    int64_t at = 0, step = count;
    for (int64_t i = c->axes; i-- > 0;) {
        if (array->dims[i] != 1)
            at += row % c->dims[i] * step;
        row /= c->dims[i];
        step *= array->dims[i];
    }
    return (const double *)array->data + at;
}

/* How many rows an argument has. */
static int64_t rows_in(const XLA_FFI_Buffer *array, const call *c)
{
    int64_t rows = 1;
    for (int64_t i = 0; i < c->axes; i++)
        rows *= array->dims[i];
    return rows;
}

static void each_row(const call *c, rates *function, int64_t size)
{
    for (int64_t i = 0; i < c->rows; i++)
        function(*row_of(c->t, c, i, 1), row_of(c->y, c, i, c->of->states),
                 row_of(c->p, c, i, c->of->width), c->out + i * size);
}

XLA_FFI_Error *rodgen_jax_rhs(XLA_FFI_CallFrame *frame)
{
    call c;
    if (asked(frame))
        return NULL;
    const char *wrong = read_call(frame, 1, &c);
    if (wrong)
        return refused(frame, wrong);
    int64_t sets = rows_in(c.p, &c);
    if (c.rows > 1 && rows_in(c.t, &c) == 1 && rows_in(c.y, &c) == c.rows
        && (sets == 1 || sets == c.rows))
        c.of->rhs_batch((size_t)c.rows, *(double *)c.t->data, c.y->data, c.p->data,
                        sets == 1 ? 0 : (size_t)c.of->width, c.out);
    else
        each_row(&c, c.of->rhs, c.of->states);
    return NULL;
}

XLA_FFI_Error *rodgen_jax_jac(XLA_FFI_CallFrame *frame)
{
    call c;
    if (asked(frame))
        return NULL;
    const char *wrong = read_call(frame, 2, &c);
    if (wrong)
        return refused(frame, wrong);
    each_row(&c, c.of->jac, c.of->states * c.of->states);
    return NULL;
}

/* Central differences of order six, by this share of what is changed. */
static const double SHARE = 1e-4, WEIGHTS[] = {45, -9, 1};

/* Derivatives of the rates by one number, which stands at `number` (in p, or is the time t), into
   every width-th number of out; at: rates, (states,). */
static void by_number(const model *of, const double *t, const double *y, const double *p,
                      double *number, int64_t width, double *at, double *out)
{
    const double value = *number, h = SHARE * (value ? fabs(value) : 1);
    for (int64_t i = 0; i < of->states; i++)
        out[i * width] = 0;
    for (int k = 1; k <= 3; k++)
        for (int sign = 1; sign >= -1; sign -= 2) {
            *number = value + sign * k * h;
            of->rhs(*t, y, p, at);
            for (int64_t i = 0; i < of->states; i++)
                out[i * width] += sign * WEIGHTS[k - 1] * at[i] / (60 * h);
        }
    *number = value;
}

/* Derivatives of the rates by t and every parameter, (..., states, 1 + parameters). */
XLA_FFI_Error *rodgen_jax_by(XLA_FFI_CallFrame *frame)
{
    call c;
    if (asked(frame))
        return NULL;
    const char *wrong = read_call(frame, 2, &c);
    if (wrong)
        return refused(frame, wrong);
    const int64_t states = c.of->states, width = c.of->width, columns = 1 + width;
    double *p = malloc(sizeof(double) * (size_t)(states + width)), *at = p + width;
    if (!p)
        return refused(frame, "not enough memory");
    for (int64_t row = 0; row < c.rows; row++) {
        const double *y = row_of(c.y, &c, row, states), *given = row_of(c.p, &c, row, width);
        double t = *row_of(c.t, &c, row, 1), *out = c.out + row * states * columns;
        for (int64_t i = 0; i < width; i++)
            p[i] = given[i];
        for (int64_t i = 0; i < states; i++)
            out[i * columns] = 0;
        if (c.of->timed)
            by_number(c.of, &t, y, p, &t, columns, at, out);
        for (int64_t i = 0; i < width; i++)
            by_number(c.of, &t, y, p, p + i, columns, at, out + 1 + i);
    }
    free(p);
    return NULL;
}
