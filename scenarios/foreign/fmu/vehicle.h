/* A wheel on its suspension: a wheel, a body above it, a spring and a dashpot between them.
 *
 *   wheel_mass a_w = wheel_force + k (z_b - z_w) + c (v_b - v_w)
 *   body_mass  a_b = -load(t)    - k (z_b - z_w) - c (v_b - v_w),    load(t) = load_n min(1, t / ramp_s)
 *
 * z is measured upwards from the unloaded start. The method of Runge and Kutta of order 4, one step a communication step, which also
 * adds up the work of the load and what the dashpot takes. With -DSTATELESS the unit can neither give nor take its state.
 */

#include <stdlib.h>
#include <string.h>

/* Value references, as in modelDescription.xml: inputs and parameters, states, and what follows from them. */
enum { FORCE, WHEEL_MASS, BODY_MASS, STIFFNESS, DAMPING, LOAD, RAMP, INPUTS };
enum { Z_WHEEL, V_WHEEL, Z_BODY, V_BODY, LOAD_WORK, DAMPER_LOSS, STATES };
enum { FIRST_STATE = INPUTS, KINETIC = INPUTS + STATES, SPRING, TIME };
enum { OK = 0, ERROR = 3 };

/* All that changes: a state of the unit is a copy of it. */
typedef struct {
    double time, in[INPUTS], x[STATES];
} Unit;

/* The start values of modelDescription.xml, which build.py writes. */
static const Unit START = {
    .in = { [WHEEL_MASS] = 1.0, [BODY_MASS] = 4.0, [STIFFNESS] = 2e7, [DAMPING] = 8e3, [LOAD] = 2e3, [RAMP] = 1e-3 },
};

static void rates(const double *in, double time, const double *x, double *rate)
{
    double slip = x[V_BODY] - x[V_WHEEL];
    double between = in[STIFFNESS] * (x[Z_BODY] - x[Z_WHEEL]) + in[DAMPING] * slip;
    double load = in[LOAD] * (time < in[RAMP] ? time / in[RAMP] : 1.0);
    rate[Z_WHEEL] = x[V_WHEEL];
    rate[V_WHEEL] = (in[FORCE] + between) / in[WHEEL_MASS];
    rate[Z_BODY] = x[V_BODY];
    rate[V_BODY] = (-load - between) / in[BODY_MASS];
    rate[LOAD_WORK] = -load * x[V_BODY];
    rate[DAMPER_LOSS] = in[DAMPING] * slip * slip;
}

static int step(Unit *unit, double h)
{
    static const double ahead[4] = { 0.0, 0.5, 0.5, 1.0 }, weight[4] = { 1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0 };
    double rate[STATES] = { 0.0 }, at[STATES], sum[STATES] = { 0.0 };
    for (int stage = 0; stage < 4; stage++) {
        for (int i = 0; i < STATES; i++)
            at[i] = unit->x[i] + ahead[stage] * h * rate[i];
        rates(unit->in, unit->time + ahead[stage] * h, at, rate);
        for (int i = 0; i < STATES; i++)
            sum[i] += weight[stage] * rate[i];
    }
    for (int i = 0; i < STATES; i++)
        unit->x[i] += h * sum[i];
    unit->time += h;
    return OK;
}

static int get(const Unit *unit, const unsigned *vr, size_t count, double *out)
{
    const double *in = unit->in, *x = unit->x;
    for (size_t i = 0; i < count; i++) {
        double stretch = x[Z_BODY] - x[Z_WHEEL];
        if (vr[i] < INPUTS)
            out[i] = in[vr[i]];
        else if (vr[i] < KINETIC)
            out[i] = x[vr[i] - FIRST_STATE];
        else if (vr[i] == KINETIC)
            out[i] = 0.5 * (in[WHEEL_MASS] * x[V_WHEEL] * x[V_WHEEL] + in[BODY_MASS] * x[V_BODY] * x[V_BODY]);
        else if (vr[i] == SPRING)
            out[i] = 0.5 * in[STIFFNESS] * stretch * stretch;
        else if (vr[i] == TIME)
            out[i] = unit->time;
        else
            return ERROR;
    }
    return OK;
}

static int set(Unit *unit, const unsigned *vr, size_t count, const double *values)
{
    for (size_t i = 0; i < count; i++) {
        if (vr[i] >= INPUTS)
            return ERROR;
        unit->in[vr[i]] = values[i];
    }
    return OK;
}

static Unit *new_unit(void)
{
    Unit *unit = malloc(sizeof *unit);
    if (unit)
        *unit = START;
    return unit;
}

#ifdef STATELESS
enum { HAS_STATE = 0 };
#else
enum { HAS_STATE = 1 };
#endif

static int get_state(const Unit *unit, void **state)
{
    if (HAS_STATE && !*state)
        *state = malloc(sizeof *unit);
    if (!HAS_STATE || !*state)
        return ERROR;
    memcpy(*state, unit, sizeof *unit);
    return OK;
}

static int set_state(Unit *unit, const void *state)
{
    if (!HAS_STATE || !state)
        return ERROR;
    memcpy(unit, state, sizeof *unit);
    return OK;
}

static int free_state(void **state)
{
    free(*state);
    *state = NULL;
    return HAS_STATE ? OK : ERROR;
}

static int size_of_state(size_t *size)
{
    *size = sizeof(Unit);
    return HAS_STATE ? OK : ERROR;
}

static int to_bytes(const void *state, void *bytes, size_t size)
{
    if (!HAS_STATE || size < sizeof(Unit))
        return ERROR;
    memcpy(bytes, state, sizeof(Unit));
    return OK;
}

static int from_bytes(const void *bytes, size_t size, void **state)
{
    return size == sizeof(Unit) ? get_state(bytes, state) : ERROR;
}
