/* The integrator of the findings, der(x) = gain*u*(mode - 1), as FMI 2.0 and FMI 3.0, co-simulation and model exchange.
 * A `stop` above 0, a parameter that a description may have, ends its motion there by an event of model exchange; in
 * co-simulation it discards all steps from there on, and says that it has terminated.
 * It writes the calls that it receives into the file that PROBE_CALLS names, one a line. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { U = 1, X = 2, RATE = 3, GAIN = 4, MOVING = 5, MODE = 6, MODE_NUMBER = 7, TIME = 8, STOP = 9 };

typedef struct { char name[32]; double time, u, slope, x, gain, stop; int mode, number; } Probe;
typedef unsigned int Ref;

static void note(const void *p, const char *format, ...) {
    const char *path = getenv("PROBE_CALLS");
    FILE *file = path ? fopen(path, "a") : NULL;
    if (!file) return;
    fprintf(file, "%s: ", ((const Probe *)p)->name);
    va_list values;
    va_start(values, format);
    vfprintf(file, format, values);
    va_end(values);
    fputc('\n', file);
    fclose(file);
}
static void start(Probe *p) { p->u = 5, p->gain = 1, p->mode = 2, p->slope = p->x = p->time = p->stop = 0, p->number = 0; }
static Probe *make(const char *name, const char *what) {
    Probe *p = calloc(1, sizeof *p);
    if (!p) return NULL;
    strncpy(p->name, name, sizeof p->name - 1);
    start(p);
    note(p, "instantiate %s", what);
    return p;
}
static int mode(const Probe *p) { return p->number ? p->number : p->mode; }
static double rate(const Probe *p) { return p->gain * p->u * (mode(p) - 1); }
static void step(Probe *p, double from, double length) {
    note(p, "step from %.9g by %.9g", from, length);
    p->x += (rate(p) + 0.5 * p->gain * p->slope * length * (mode(p) - 1)) * length;
    p->time = from + length;
}
static int set_real(Probe *p, Ref ref, double value) {
    note(p, "set real %u %.9g", ref, value);
    switch (ref) {
        case U: p->u = value; return 0;
        case X: p->x = value; return 0;
        case GAIN: p->gain = value; return 0;
        case STOP: p->stop = value; return 0;
        default: return ref > 100 ? 0 : 3; /* inputs without effect */
    }
}
static int get_real(const Probe *p, Ref ref, double *value) {
    switch (ref) {
        case U: *value = p->u; return 0;
        case X: *value = p->x; return 0;
        case RATE: *value = rate(p); return 0;
        case GAIN: *value = p->gain; return 0;
        case STOP: *value = p->stop; return 0;
        case TIME: *value = p->time; return 0;
        default: note(p, "get real %u refused", ref); return 3;
    }
}
static int set_integer(Probe *p, Ref ref, int value) {
    note(p, "set integer %u %d", ref, value);
    if (ref == MODE) p->mode = value;
    else if (ref == MODE_NUMBER) p->number = value;
    else return 3;
    return 0;
}
static int get_integer(const Probe *p, Ref ref, int *value) {
    if (ref == MODE) *value = p->mode;
    else if (ref == MODE_NUMBER) *value = p->number;
    else return 3;
    return 0;
}
static int worst(int a, int b) { return a > b ? a : b; }

/* FMI 2.0 */
typedef struct { int discrete, terminate, nominals, states, defined; double next; } Event2;
const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }
int fmi2SetDebugLogging(void *p, int on, size_t n, const char *const c[]) { (void)p; (void)on; (void)n; (void)c; return 0; }
void *fmi2Instantiate(const char *name, int kind, const char *guid, const char *place, const void *callbacks, int visible, int log) {
    (void)guid; (void)place; (void)callbacks; (void)visible; (void)log;
    return make(name, kind ? "co-simulation" : "model exchange");
}
void fmi2FreeInstance(void *p) { free(p); }
int fmi2SetupExperiment(void *p, int defined, double tolerance, double start, int ends, double stop) {
    ((Probe *)p)->time = start;
    if (defined) note(p, "tolerance %.9g", tolerance); else note(p, "no tolerance");
    (void)ends; (void)stop;
    return 0;
}
int fmi2EnterInitializationMode(void *p) { note(p, "enter initialization"); return 0; }
int fmi2ExitInitializationMode(void *p) { note(p, "exit initialization with u %.9g mode %d", ((Probe *)p)->u, mode(p)); return 0; }
int fmi2Terminate(void *p) { note(p, "terminate"); return 0; }
int fmi2Reset(void *p) { note(p, "reset"); start(p); return 0; }
#define EACH(type, call) int worse = 0; for (size_t i = 0; i < n; i++) worse = worst(worse, call); return worse
int fmi2SetReal(void *p, const Ref r[], size_t n, const double v[]) { EACH(double, set_real(p, r[i], v[i])); }
int fmi2GetReal(void *p, const Ref r[], size_t n, double v[]) { EACH(double, get_real(p, r[i], &v[i])); }
int fmi2SetInteger(void *p, const Ref r[], size_t n, const int v[]) { EACH(int, set_integer(p, r[i], v[i])); }
int fmi2GetInteger(void *p, const Ref r[], size_t n, int v[]) { EACH(int, get_integer(p, r[i], &v[i])); }
int fmi2SetBoolean(void *p, const Ref r[], size_t n, const int v[]) { (void)p; (void)r; (void)v; return n ? 3 : 0; }
int fmi2GetBoolean(void *p, const Ref r[], size_t n, int v[]) { for (size_t i = 0; i < n; i++) { if (r[i] != MOVING) return 3; v[i] = rate(p) != 0; } return 0; }
int fmi2SetString(void *p, const Ref r[], size_t n, const char *const v[]) { (void)p; (void)r; (void)v; return n ? 3 : 0; }
int fmi2GetString(void *p, const Ref r[], size_t n, const char *v[]) { (void)p; (void)r; (void)v; return n ? 3 : 0; }
int fmi2GetFMUstate(void *p, void **s) { if (!*s) *s = malloc(sizeof(Probe)); memcpy(*s, p, sizeof(Probe)); return 0; }
int fmi2SetFMUstate(void *p, void *s) { memcpy(p, s, sizeof(Probe)); return 0; }
int fmi2FreeFMUstate(void *p, void **s) { (void)p; free(*s); *s = NULL; return 0; }
int fmi2SerializedFMUstateSize(void *p, void *s, size_t *n) { (void)p; (void)s; *n = sizeof(Probe); return 0; }
int fmi2SerializeFMUstate(void *p, void *s, char b[], size_t n) { (void)p; memcpy(b, s, n); return 0; }
int fmi2DeSerializeFMUstate(void *p, const char b[], size_t n, void **s) { (void)p; *s = malloc(n); memcpy(*s, b, n); return 0; }
static int directional(const Probe *p, const Ref z[], size_t nz, const Ref v[], size_t nv, const double dv[], double dz[]) {
    for (size_t i = 0; i < nz; i++) {
        dz[i] = 0;
        for (size_t k = 0; k < nv; k++) {
            if (z[i] == RATE && v[k] == U) dz[i] += p->gain * (mode(p) - 1) * dv[k];
            if (z[i] == RATE && v[k] == GAIN) dz[i] += p->u * (mode(p) - 1) * dv[k];
            if (z[i] == X && v[k] == X) dz[i] += dv[k];
        }
    }
    return 0;
}
int fmi2GetDirectionalDerivative(void *p, const Ref z[], size_t nz, const Ref v[], size_t nv, const double dv[], double dz[]) { return directional(p, z, nz, v, nv, dv, dz); }
int fmi2SetRealInputDerivatives(void *p, const Ref r[], size_t n, const int order[], const double v[]) {
    for (size_t i = 0; i < n; i++) { note(p, "set slope %u order %d %.9g", r[i], order[i], v[i]); if (r[i] == U) ((Probe *)p)->slope = v[i]; }
    return 0;
}
int fmi2GetRealOutputDerivatives(void *p, const Ref r[], size_t n, const int order[], double v[]) { (void)p; (void)r; (void)order; (void)v; return n ? 3 : 0; }
static int has_ended(const Probe *p) { return p->stop > 0 && p->x >= p->stop; }
int fmi2DoStep(void *p, double from, double length, int keep) {
    (void)keep;
    if (has_ended(p)) return 2;
    step(p, from, length);
    return 0;
}
int fmi2CancelStep(void *p) { (void)p; return 3; }
int fmi2GetStatus(void *p, int kind, int *v) { (void)p; (void)kind; (void)v; return 1; }
int fmi2GetRealStatus(void *p, int kind, double *v) { (void)kind; *v = ((Probe *)p)->time; return 0; }
int fmi2GetIntegerStatus(void *p, int kind, int *v) { (void)p; (void)kind; (void)v; return 1; }
int fmi2GetBooleanStatus(void *p, int kind, int *v) { (void)kind; *v = has_ended(p); return 0; }
int fmi2GetStringStatus(void *p, int kind, const char **v) { (void)p; (void)kind; (void)v; return 1; }
int fmi2EnterEventMode(void *p) { (void)p; return 0; }
int fmi2NewDiscreteStates(void *p, Event2 *e) {
    Probe *probe = p;
    memset(e, 0, sizeof *e);
    if (probe->stop > 0 && probe->x >= probe->stop) probe->mode = 1;
    return 0;
}
int fmi2EnterContinuousTimeMode(void *p) { note(p, "enter continuous time"); return 0; }
int fmi2CompletedIntegratorStep(void *p, int keep, int *event, int *end) { (void)p; (void)keep; *event = *end = 0; return 0; }
int fmi2SetTime(void *p, double time) { ((Probe *)p)->time = time; return 0; }
int fmi2SetContinuousStates(void *p, const double x[], size_t n) { if (n) ((Probe *)p)->x = x[0]; return 0; }
int fmi2GetDerivatives(void *p, double d[], size_t n) { if (n) d[0] = rate(p); return 0; }
int fmi2GetEventIndicators(void *p, double z[], size_t n) {
    if (n) note(p, "event indicators");
    for (size_t i = 0; i < n; i++) z[i] = ((Probe *)p)->stop - ((Probe *)p)->x;
    return 0;
}
int fmi2GetContinuousStates(void *p, double x[], size_t n) { if (n) x[0] = ((Probe *)p)->x; return 0; }
int fmi2GetNominalsOfContinuousStates(void *p, double x[], size_t n) { (void)p; if (n) x[0] = 1; return 0; }

/* FMI 3.0 */
const char *fmi3GetVersion(void) { return "3.0"; }
int fmi3SetDebugLogging(void *p, bool on, size_t n, const char *const c[]) { (void)p; (void)on; (void)n; (void)c; return 0; }
void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *place, bool visible, bool log, bool events, bool early,
                                  const Ref required[], size_t n, void *environment, void *logger, void *update) {
    (void)token; (void)place; (void)visible; (void)log; (void)events; (void)early;
    (void)required; (void)n; (void)environment; (void)logger; (void)update;
    return make(name, "co-simulation");
}
void *fmi3InstantiateModelExchange(const char *name, const char *token, const char *place, bool visible, bool log, void *environment, void *logger) {
    (void)token; (void)place; (void)visible; (void)log; (void)environment; (void)logger;
    return make(name, "model exchange");
}
void *fmi3InstantiateScheduledExecution(const char *n, const char *t, const char *r, bool v, bool l, void *e, void *m, void *c, void *o, void *u) {
    (void)n; (void)t; (void)r; (void)v; (void)l; (void)e; (void)m; (void)c; (void)o; (void)u;
    return NULL;
}
void fmi3FreeInstance(void *p) { free(p); }
int fmi3EnterInitializationMode(void *p, bool defined, double tolerance, double start, bool ends, double stop) {
    (void)fmi2SetupExperiment(p, defined, tolerance, start, ends, stop);
    return fmi2EnterInitializationMode(p);
}
int fmi3ExitInitializationMode(void *p) { return fmi2ExitInitializationMode(p); }
int fmi3EnterEventMode(void *p) { (void)p; return 0; }
int fmi3Terminate(void *p) { return fmi2Terminate(p); }
int fmi3Reset(void *p) { return fmi2Reset(p); }
int fmi3SetFloat64(void *p, const Ref r[], size_t n, const double v[], size_t m) { (void)m; return fmi2SetReal(p, r, n, v); }
int fmi3GetFloat64(void *p, const Ref r[], size_t n, double v[], size_t m) { (void)m; return fmi2GetReal(p, r, n, v); }
int fmi3SetInt32(void *p, const Ref r[], size_t n, const int32_t v[], size_t m) { (void)m; return fmi2SetInteger(p, r, n, v); }
int fmi3GetInt32(void *p, const Ref r[], size_t n, int32_t v[], size_t m) { (void)m; return fmi2GetInteger(p, r, n, v); }
int fmi3SetInt64(void *p, const Ref r[], size_t n, const int64_t v[], size_t m) { (void)m; EACH(int64_t, r[i] == MODE ? set_integer(p, MODE, (int)v[i]) : 3); }
int fmi3GetInt64(void *p, const Ref r[], size_t n, int64_t v[], size_t m) { (void)m; for (size_t i = 0; i < n; i++) { if (r[i] != MODE) return 3; v[i] = ((Probe *)p)->mode; } return 0; }
int fmi3SetBoolean(void *p, const Ref r[], size_t n, const bool v[], size_t m) { (void)p; (void)r; (void)v; (void)m; return n ? 3 : 0; }
int fmi3GetBoolean(void *p, const Ref r[], size_t n, bool v[], size_t m) { (void)m; for (size_t i = 0; i < n; i++) { if (r[i] != MOVING) return 3; v[i] = rate(p) != 0; } return 0; }
int fmi3GetFMUState(void *p, void **s) { return fmi2GetFMUstate(p, s); }
int fmi3SetFMUState(void *p, void *s) { return fmi2SetFMUstate(p, s); }
int fmi3FreeFMUState(void *p, void **s) { return fmi2FreeFMUstate(p, s); }
int fmi3SerializedFMUStateSize(void *p, void *s, size_t *n) { return fmi2SerializedFMUstateSize(p, s, n); }
int fmi3SerializeFMUState(void *p, void *s, uint8_t b[], size_t n) { return fmi2SerializeFMUstate(p, s, (char *)b, n); }
int fmi3DeserializeFMUState(void *p, const uint8_t b[], size_t n, void **s) { return fmi2DeSerializeFMUstate(p, (const char *)b, n, s); }
int fmi3GetDirectionalDerivative(void *p, const Ref z[], size_t nz, const Ref v[], size_t nv, const double dv[], size_t a, double dz[], size_t b) { (void)a; (void)b; return directional(p, z, nz, v, nv, dv, dz); }
int fmi3EnterConfigurationMode(void *p) { (void)p; return 0; }
int fmi3ExitConfigurationMode(void *p) { (void)p; return 0; }
int fmi3EvaluateDiscreteStates(void *p) { (void)p; return 0; }
int fmi3UpdateDiscreteStates(void *p, bool *a, bool *b, bool *c, bool *d, bool *e, double *t) { (void)p; *a = *b = *c = *d = *e = false; *t = 0; return 0; }
int fmi3EnterContinuousTimeMode(void *p) { return fmi2EnterContinuousTimeMode(p); }
int fmi3CompletedIntegratorStep(void *p, bool keep, bool *event, bool *end) { (void)p; (void)keep; *event = *end = false; return 0; }
int fmi3SetTime(void *p, double time) { return fmi2SetTime(p, time); }
int fmi3SetContinuousStates(void *p, const double x[], size_t n) { return fmi2SetContinuousStates(p, x, n); }
int fmi3GetContinuousStateDerivatives(void *p, double d[], size_t n) { return fmi2GetDerivatives(p, d, n); }
int fmi3GetEventIndicators(void *p, double z[], size_t n) { return fmi2GetEventIndicators(p, z, n); }
int fmi3GetContinuousStates(void *p, double x[], size_t n) { return fmi2GetContinuousStates(p, x, n); }
int fmi3GetNominalsOfContinuousStates(void *p, double x[], size_t n) { return fmi2GetNominalsOfContinuousStates(p, x, n); }
int fmi3GetNumberOfEventIndicators(void *p, size_t *n) { (void)p; *n = 0; return 0; }
int fmi3GetNumberOfContinuousStates(void *p, size_t *n) { (void)p; *n = 1; return 0; }
int fmi3EnterStepMode(void *p) { (void)p; return 0; }
int fmi3GetOutputDerivatives(void *p, const Ref r[], size_t n, const int32_t o[], double v[], size_t m) { (void)p; (void)r; (void)o; (void)v; (void)m; return n ? 3 : 0; }
int fmi3DoStep(void *p, double from, double length, bool keep, bool *event, bool *end, bool *early, double *last) {
    (void)keep;
    step(p, from, length);
    *event = *end = *early = false;
    *last = from + length;
    return 0;
}
/* Functions that importers look up and this FMU does not need. */
#define UNUSED(name) int fmi3##name(void) { return 3; }
UNUSED(GetFloat32) UNUSED(SetFloat32) UNUSED(GetInt8) UNUSED(SetInt8) UNUSED(GetUInt8) UNUSED(SetUInt8) UNUSED(GetInt16) UNUSED(SetInt16)
UNUSED(GetUInt16) UNUSED(SetUInt16) UNUSED(GetUInt32) UNUSED(SetUInt32) UNUSED(GetUInt64) UNUSED(SetUInt64) UNUSED(GetString) UNUSED(SetString)
UNUSED(GetBinary) UNUSED(SetBinary) UNUSED(GetClock) UNUSED(SetClock) UNUSED(GetNumberOfVariableDependencies) UNUSED(GetVariableDependencies)
UNUSED(GetAdjointDerivative) UNUSED(GetIntervalDecimal) UNUSED(GetIntervalFraction) UNUSED(GetShiftDecimal) UNUSED(GetShiftFraction)
UNUSED(SetIntervalDecimal) UNUSED(SetIntervalFraction) UNUSED(SetShiftDecimal) UNUSED(SetShiftFraction) UNUSED(ActivateModelPartition)
