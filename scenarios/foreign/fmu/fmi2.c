/* The vehicle behind the functions of FMI 2.0 for co-simulation. */

#include "vehicle.h"

/* What no variable of this unit needs. */
#define NOT(name) int name(void) { return ERROR; }

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }
void *fmi2Instantiate(void) { return new_unit(); }
void fmi2FreeInstance(Unit *unit) { free(unit); }
int fmi2SetDebugLogging(void) { return OK; }
int fmi2SetupExperiment(Unit *unit, int has_tolerance, double tolerance, double start)
{
    (void)has_tolerance, (void)tolerance;
    unit->time = start;
    return OK;
}
int fmi2EnterInitializationMode(void) { return OK; }
int fmi2ExitInitializationMode(void) { return OK; }
int fmi2Terminate(void) { return OK; }
int fmi2Reset(Unit *unit) { *unit = START; return OK; }
int fmi2GetReal(Unit *unit, const unsigned *vr, size_t count, double *values) { return get(unit, vr, count, values); }
int fmi2SetReal(Unit *unit, const unsigned *vr, size_t count, const double *values) { return set(unit, vr, count, values); }
int fmi2DoStep(Unit *unit, double time, double h) { (void)time; return step(unit, h); }
int fmi2GetFMUstate(Unit *unit, void **state) { return get_state(unit, state); }
int fmi2SetFMUstate(Unit *unit, void *state) { return set_state(unit, state); }
int fmi2FreeFMUstate(Unit *unit, void **state) { (void)unit; return free_state(state); }
int fmi2SerializedFMUstateSize(Unit *unit, void *state, size_t *size) { (void)unit, (void)state; return size_of_state(size); }
int fmi2SerializeFMUstate(Unit *unit, void *state, char *bytes, size_t size) { (void)unit; return to_bytes(state, bytes, size); }
int fmi2DeSerializeFMUstate(Unit *unit, const char *bytes, size_t size, void **state) { (void)unit; return from_bytes(bytes, size, state); }

NOT(fmi2GetInteger) NOT(fmi2GetBoolean) NOT(fmi2GetString) NOT(fmi2SetInteger) NOT(fmi2SetBoolean) NOT(fmi2SetString)
NOT(fmi2GetDirectionalDerivative) NOT(fmi2SetRealInputDerivatives) NOT(fmi2GetRealOutputDerivatives) NOT(fmi2CancelStep)
NOT(fmi2GetStatus) NOT(fmi2GetRealStatus) NOT(fmi2GetIntegerStatus) NOT(fmi2GetBooleanStatus) NOT(fmi2GetStringStatus)
