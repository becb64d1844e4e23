/* The vehicle behind the functions of FMI 3.0 for co-simulation. */

#include <stdbool.h>

#include "vehicle.h"

/* What no variable of this unit needs. */
#define NOT(name) int fmi3##name(void) { return ERROR; }

const char *fmi3GetVersion(void) { return "3.0"; }
void *fmi3InstantiateModelExchange(void) { return NULL; }
void *fmi3InstantiateCoSimulation(void) { return new_unit(); }
void *fmi3InstantiateScheduledExecution(void) { return NULL; }
void fmi3FreeInstance(Unit *unit) { free(unit); }
int fmi3SetDebugLogging(void) { return OK; }
int fmi3EnterInitializationMode(Unit *unit, bool has_tolerance, double tolerance, double start)
{
    (void)has_tolerance, (void)tolerance;
    unit->time = start;
    return OK;
}
int fmi3ExitInitializationMode(void) { return OK; }
int fmi3Terminate(void) { return OK; }
int fmi3Reset(Unit *unit) { *unit = START; return OK; }
int fmi3GetFloat64(Unit *unit, const unsigned *vr, size_t count, double *values) { return get(unit, vr, count, values); }
int fmi3SetFloat64(Unit *unit, const unsigned *vr, size_t count, const double *values) { return set(unit, vr, count, values); }
int fmi3DoStep(Unit *unit, double time, double h, bool keeps, bool *event, bool *ended, bool *early, double *reached)
{
    (void)keeps;
    *event = *ended = *early = false;
    *reached = time + h;
    return step(unit, h);
}
int fmi3GetFMUState(Unit *unit, void **state) { return get_state(unit, state); }
int fmi3SetFMUState(Unit *unit, void *state) { return set_state(unit, state); }
int fmi3FreeFMUState(Unit *unit, void **state) { (void)unit; return free_state(state); }
int fmi3SerializedFMUStateSize(Unit *unit, void *state, size_t *size) { (void)unit, (void)state; return size_of_state(size); }
int fmi3SerializeFMUState(Unit *unit, void *state, char *bytes, size_t size) { (void)unit; return to_bytes(state, bytes, size); }
int fmi3DeserializeFMUState(Unit *unit, const char *bytes, size_t size, void **state) { (void)unit; return from_bytes(bytes, size, state); }

NOT(GetFloat32) NOT(GetInt8) NOT(GetUInt8) NOT(GetInt16) NOT(GetUInt16) NOT(GetInt32) NOT(GetUInt32) NOT(GetInt64) NOT(GetUInt64)
NOT(SetFloat32) NOT(SetInt8) NOT(SetUInt8) NOT(SetInt16) NOT(SetUInt16) NOT(SetInt32) NOT(SetUInt32) NOT(SetInt64) NOT(SetUInt64)
NOT(GetBoolean) NOT(GetString) NOT(GetBinary) NOT(GetClock) NOT(SetBoolean) NOT(SetString) NOT(SetBinary) NOT(SetClock)
NOT(EnterEventMode) NOT(EnterStepMode) NOT(EnterConfigurationMode) NOT(ExitConfigurationMode) NOT(EnterContinuousTimeMode)
NOT(GetNumberOfVariableDependencies) NOT(GetVariableDependencies) NOT(GetDirectionalDerivative) NOT(GetAdjointDerivative)
NOT(GetIntervalDecimal) NOT(GetIntervalFraction) NOT(GetShiftDecimal) NOT(GetShiftFraction) NOT(SetIntervalDecimal)
NOT(SetIntervalFraction) NOT(SetShiftDecimal) NOT(SetShiftFraction) NOT(EvaluateDiscreteStates) NOT(UpdateDiscreteStates)
NOT(CompletedIntegratorStep) NOT(SetTime) NOT(SetContinuousStates) NOT(GetContinuousStateDerivatives) NOT(GetEventIndicators)
NOT(GetContinuousStates) NOT(GetNominalsOfContinuousStates) NOT(GetNumberOfEventIndicators) NOT(GetNumberOfContinuousStates)
NOT(GetOutputDerivatives) NOT(ActivateModelPartition)
