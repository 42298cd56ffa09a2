/* FMI 2.0 co-simulation around a controller: a communication step of n control periods runs n control steps with the inputs
   that were set at its beginning. What belongs to the controller at hand stands in binding.h: GUID, period, numbers of
   variables, start values, and the way between variables and the controller's own records. */

#include <math.h>
#include <string.h>

#include "binding.h"
#include "fmi2_interface.h"

/* In control periods: tolerance of a communication step against whole ones, of its time against our own, longest step. */
#define STEP_TOLERANCE 1e-6
#define CLOCK_TOLERANCE 1e-3
#define MOST_PERIODS 1e6

enum mode { INSTANTIATED, INITIALIZING, STEPPING, TERMINATED };

/* Everything that a simulation changes; a saved FMU state is a copy of it. */
typedef struct {
    enum mode mode;
    double start_time;
    double periods;
    double in[INPUTS];
    double out[OUTPUTS];
    gainproof_state controller;
} model_state;

typedef struct {
    model_state now;
    const fmi2CallbackFunctions *call;
    char name[128];
} instance;

static fmi2Status complain(const instance *self, const char *message)
{
    if (self->call->logger != NULL)
        self->call->logger(self->call->componentEnvironment, self->name, fmi2Error, "logStatusError", "%s", message);
    return fmi2Error;
}

static void rewind_to_start(model_state *now)
{
    memset(now, 0, sizeof *now);
    memcpy(now->in, start_inputs, sizeof now->in);
    memcpy(now->out, start_outputs, sizeof now->out);
}

const char *fmi2GetTypesPlatform(void)
{
    return "default";
}

const char *fmi2GetVersion(void)
{
    return "2.0";
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t count, const fmi2String categories[])
{
    (void)c, (void)on, (void)count, (void)categories;
    return fmi2OK;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *call, fmi2Boolean visible, fmi2Boolean logging)
{
    instance *self;
    (void)resources, (void)visible, (void)logging;
    if (call == NULL || call->allocateMemory == NULL || call->freeMemory == NULL)
        return NULL;
    if (name == NULL || type != fmi2CoSimulation || guid == NULL || strcmp(guid, MODEL_GUID) != 0) {
        if (call->logger != NULL)
            call->logger(call->componentEnvironment, name != NULL ? name : "?", fmi2Error, "logStatusError", "%s",
                         "This is a co-simulation FMU with the GUID " MODEL_GUID "; another type or GUID was asked for.");
        return NULL;
    }
    self = (instance *)call->allocateMemory(1, sizeof *self);
    if (self == NULL)
        return NULL;
    memset(self, 0, sizeof *self);
    strncpy(self->name, name, sizeof self->name - 1);
    self->call = call;
    rewind_to_start(&self->now);
    return self;
}

void fmi2FreeInstance(fmi2Component c)
{
    instance *self = (instance *)c;
    if (self != NULL)
        self->call->freeMemory(self);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerance_defined, fmi2Real tolerance, fmi2Real start_time,
                               fmi2Boolean stop_defined, fmi2Real stop_time)
{
    instance *self = (instance *)c;
    (void)tolerance_defined, (void)tolerance, (void)stop_defined, (void)stop_time;
    if (self->now.mode != INSTANTIATED)
        return complain(self, "fmi2SetupExperiment was called after initialization.");
    self->now.start_time = start_time;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    instance *self = (instance *)c;
    if (self->now.mode != INSTANTIATED)
        return complain(self, "fmi2EnterInitializationMode was called twice; call fmi2Reset first.");
    self->now.mode = INITIALIZING;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    instance *self = (instance *)c;
    if (self->now.mode != INITIALIZING)
        return complain(self, "fmi2ExitInitializationMode was called outside initialization.");
    if (start_controller(&self->now.controller, self->now.in) != 0)
        return complain(self, "The controller refused the measurement that it was to start from: a value is not finite.");
    self->now.mode = STEPPING;
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    ((instance *)c)->now.mode = TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c)
{
    rewind_to_start(&((instance *)c)->now);
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference refs[], size_t count, fmi2Real values[])
{
    const instance *self = (const instance *)c;
    for (size_t i = 0; i < count; ++i) {
        const fmi2ValueReference ref = refs[i];
        if (ref < INPUTS)
            values[i] = self->now.in[ref];
        else if (ref < INPUTS + OUTPUTS)
            values[i] = self->now.out[ref - INPUTS];
        else if (ref < INPUTS + OUTPUTS + CONSTANTS)
            values[i] = constants[ref - INPUTS - OUTPUTS];
        else
            return complain(self, "fmi2GetReal was asked for a variable that does not exist.");
    }
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference refs[], size_t count, const fmi2Real values[])
{
    instance *self = (instance *)c;
    for (size_t i = 0; i < count; ++i) {
        if (refs[i] >= INPUTS)
            return complain(self, "fmi2SetReal can set inputs only; gains are built in, export the FMU again to change them.");
        self->now.in[refs[i]] = values[i];
    }
    return fmi2OK;
}

static fmi2Status none_of_that_type(fmi2Component c, size_t count)
{
    return count == 0 ? fmi2OK : complain((const instance *)c, "All variables of this FMU are of type Real.");
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference refs[], size_t count, fmi2Integer values[])
{
    (void)refs, (void)values;
    return none_of_that_type(c, count);
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference refs[], size_t count, fmi2Boolean values[])
{
    (void)refs, (void)values;
    return none_of_that_type(c, count);
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference refs[], size_t count, fmi2String values[])
{
    (void)refs, (void)values;
    return none_of_that_type(c, count);
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference refs[], size_t count, const fmi2Integer values[])
{
    (void)refs, (void)values;
    return none_of_that_type(c, count);
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference refs[], size_t count, const fmi2Boolean values[])
{
    (void)refs, (void)values;
    return none_of_that_type(c, count);
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference refs[], size_t count, const fmi2String values[])
{
    (void)refs, (void)values;
    return none_of_that_type(c, count);
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_set_state)
{
    instance *self = (instance *)c;
    model_state *now = &self->now;
    const double count = floor(step / CONTROL_PERIOD + 0.5);
    const double own_time = now->start_time + now->periods * CONTROL_PERIOD;
    (void)no_set_state;
    if (now->mode != STEPPING)
        return complain(self, "fmi2DoStep was called before initialization or after an error.");
    if (!(count >= 1.0 && count <= MOST_PERIODS && fabs(step - count * CONTROL_PERIOD) <= STEP_TOLERANCE * CONTROL_PERIOD))
        return complain(self, "The communication step must be a whole number of control periods of " PERIOD_TEXT " s.");
    if (!(fabs(time - own_time) <= CLOCK_TOLERANCE * CONTROL_PERIOD))
        return complain(self, "The communication point is not where the last step ended.");
    for (double k = 0.0; k < count; k += 1.0)
        if (step_controller(&now->controller, now->in, now->out) != 0) {
            now->mode = TERMINATED;
            return complain(self, "The controller refused its inputs: a value is not finite.");
        }
    now->periods += count;
    return fmi2OK;
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    const instance *self = (const instance *)c;
    if (*state == NULL)
        *state = self->call->allocateMemory(1, sizeof self->now);
    if (*state == NULL)
        return complain(self, "There is no memory for a copy of the state.");
    memcpy(*state, &self->now, sizeof self->now);
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state)
{
    instance *self = (instance *)c;
    memcpy(&self->now, state, sizeof self->now);
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    const instance *self = (const instance *)c;
    if (*state != NULL)
        self->call->freeMemory(*state);
    *state = NULL;
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    (void)c, (void)state;
    *size = sizeof(model_state);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    if (size < sizeof(model_state))
        return complain((const instance *)c, "The buffer is smaller than fmi2SerializedFMUstateSize said.");
    memcpy(bytes, state, sizeof(model_state));
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
{
    const instance *self = (const instance *)c;
    if (size != sizeof(model_state))
        return complain(self, "The bytes are no state of this FMU.");
    if (*state == NULL)
        *state = self->call->allocateMemory(1, sizeof(model_state));
    if (*state == NULL)
        return complain(self, "There is no memory for a copy of the state.");
    memcpy(*state, bytes, sizeof(model_state));
    return fmi2OK;
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknowns[], size_t unknown_count,
                                        const fmi2ValueReference knowns[], size_t known_count, const fmi2Real seeds[],
                                        fmi2Real derivatives[])
{
    (void)unknowns, (void)unknown_count, (void)knowns, (void)known_count, (void)seeds, (void)derivatives;
    return complain((const instance *)c, "This FMU does not offer directional derivatives.");
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference refs[], size_t count,
                                       const fmi2Integer orders[], const fmi2Real values[])
{
    (void)refs, (void)count, (void)orders, (void)values;
    return complain((const instance *)c, "This FMU does not interpolate inputs.");
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference refs[], size_t count,
                                        const fmi2Integer orders[], fmi2Real values[])
{
    (void)refs, (void)count, (void)orders, (void)values;
    return complain((const instance *)c, "This FMU does not offer derivatives of outputs.");
}

fmi2Status fmi2CancelStep(fmi2Component c)
{
    return complain((const instance *)c, "Steps of this FMU cannot be cancelled; they are never pending.");
}

fmi2Status fmi2GetStatus(fmi2Component c, fmi2StatusKind kind, fmi2Status *value)
{
    (void)c, (void)kind, (void)value;
    return fmi2Discard;
}

fmi2Status fmi2GetRealStatus(fmi2Component c, fmi2StatusKind kind, fmi2Real *value)
{
    const model_state *now = &((const instance *)c)->now;
    if (kind != fmi2LastSuccessfulTime)
        return fmi2Discard;
    *value = now->start_time + now->periods * CONTROL_PERIOD;
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, fmi2StatusKind kind, fmi2Integer *value)
{
    (void)c, (void)kind, (void)value;
    return fmi2Discard;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, fmi2StatusKind kind, fmi2Boolean *value)
{
    if (kind != fmi2Terminated)
        return fmi2Discard;
    *value = ((const instance *)c)->now.mode == TERMINATED ? fmi2True : fmi2False;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, fmi2StatusKind kind, fmi2String *value)
{
    (void)c, (void)kind, (void)value;
    return fmi2Discard;
}
