/* Controller FMU for the tests: flight software of the boosters, FMI 2.0 or 3.0 (-DFMI=2, 3), by the standards' text.
 * Value references: 0 … 3 inputs kr1 … kr4; 100 + channel outputs; 200: an input body position; see fmuloop_test.py.
 * -DHOSTILE=n spoils something; n in hostile() below. */
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#ifndef HOSTILE
#define HOSTILE 0
#endif
enum { kSound, kErrorAtStep, kNanOutput, kErrorAtSet, kEnds, kReturnsEarly, kFatalAtStep, kOtherVersion, kWarnsFromStep };

/* Outputs of a booster i = 0 … 3, numbered 100 + 5 i + kind; the verniers: 120. */
enum { kThrottle, kRudder, kTies, kCutoff, kNozzle, kKinds };
enum { kOutputs = 21, kVerniers = 20, kBoosters = 4, kOk = 0, kWarning = 1, kError = 3, kFatal = 4 };

typedef struct {
  double contact[kBoosters], outputs[kOutputs], position;
  long tick, contact_tick[kBoosters];
} Controller;

static void update(Controller* c) {
  for (int i = 0; i < kBoosters; ++i) {
    double* booster = c->outputs + kKinds * i;
    if (c->tick >= 100) booster[kThrottle] = 0.84;
    if (c->tick >= 300) booster[kRudder] = 0;
    if (c->tick >= 450) booster[kTies] = 1;
    if (c->tick >= 500) booster[kCutoff] = 1;
    if (c->contact_tick[i] < 0 && c->contact[i] > 0.5) c->contact_tick[i] = c->tick;
    if (c->contact_tick[i] >= 0 && c->tick >= c->contact_tick[i] + 12) booster[kNozzle] = 1;
  }
  if (c->tick >= 250) c->outputs[kVerniers] = 0;
}

static void* create(const char* token) {
  if (strcmp(token, TOKEN) != 0) return NULL;
  Controller* c = calloc(1, sizeof *c);
  if (c == NULL) return NULL;
  for (int i = 0; i < kBoosters; ++i) {
    c->contact_tick[i] = -1;
    c->outputs[kKinds * i + kThrottle] = c->outputs[kKinds * i + kRudder] = 1;
  }
  c->outputs[kVerniers] = 1;
  return c;
}

static int step(Controller* c, double time, double size) {
  c->tick = lround((time + size) * 1000);
  if (HOSTILE == kErrorAtStep && c->tick == 200) return kError;
  if (HOSTILE == kFatalAtStep && c->tick == 200) return kFatal;
  update(c);
  if (HOSTILE == kWarnsFromStep && c->tick >= 200) return kWarning;
  if (HOSTILE == kNanOutput && c->tick == 200) c->outputs[kThrottle] = NAN;
  return kOk;
}

static double* find(Controller* c, uint32_t reference) {
  if (reference < kBoosters) return c->contact + reference;
  if (reference >= 100 && reference < 100 + kOutputs) return c->outputs + (reference - 100);
  return reference == 200 ? &c->position : NULL;
}

static int access_values(Controller* c, const uint32_t* references, size_t count, double* get, const double* set) {
  for (size_t i = 0; i < count; ++i) {
    double* value = find(c, references[i]);
    if (value == NULL || (HOSTILE == kErrorAtSet && set != NULL)) return kError;
    if (get != NULL) get[i] = *value;
    if (set != NULL) *value = set[i];
  }
  return kOk;
}

static const char* version(void) { return HOSTILE == kOtherVersion ? "1.0" : FMI == 2 ? "2.0" : "3.0"; }

#if FMI == 2
typedef void Logger(void*, const char*, int, const char*, const char*, ...);
typedef struct {
  Logger* logger;
  void *allocate, *release, *finished, *environment;
} Callbacks;
static const Callbacks* callbacks;

const char* fmi2GetVersion(void) { return version(); }
void* fmi2Instantiate(const char* name, int type, const char* guid, const char* resources, const Callbacks* given, int v, int l) {
  (void)name, (void)resources, (void)v, (void)l;
  callbacks = given;
  return type == 1 ? create(guid) : NULL;
}
void fmi2FreeInstance(void* c) { free(c); }
int fmi2SetupExperiment(void* c, int t, double tolerance, double start, int s, double stop) {
  (void)c, (void)t, (void)tolerance, (void)start, (void)s, (void)stop;
  return kOk;
}
int fmi2EnterInitializationMode(void* c) { return c == NULL ? kError : kOk; }
int fmi2ExitInitializationMode(void* c) {
  update(c);
  return kOk;
}
int fmi2Terminate(void* c) { return c == NULL ? kError : kOk; }
int fmi2GetReal(void* c, const uint32_t* r, size_t n, double* values) { return access_values(c, r, n, values, NULL); }
int fmi2SetReal(void* c, const uint32_t* r, size_t n, const double* values) { return access_values(c, r, n, NULL, values); }
int fmi2GetBoolean(void* c, const uint32_t* r, size_t n, int* values) {
  double value = 0;
  const int status = n == 1 ? access_values(c, r, n, &value, NULL) : kError;
  values[0] = value != 0;
  return status;
}
int fmi2SetBoolean(void* c, const uint32_t* r, size_t n, const int* values) {
  const double value = values[0];
  return n == 1 ? access_values(c, r, n, NULL, &value) : kError;
}
#ifndef WITHOUT_STEP
int fmi2DoStep(void* c, double time, double size, int discard) {
  (void)discard;
  const int status = step(c, time, size);
  if (status != kOk) callbacks->logger(callbacks->environment, "controller", status, "logStatusError", "gyro %d has failed", 7);
  return status;
}
#endif
#else
typedef void Logger(void*, int, const char*, const char*);
static Logger* logger;
static void* environment;

const char* fmi3GetVersion(void) { return version(); }
void* fmi3InstantiateCoSimulation(const char* name, const char* token, const char* resources, bool v, bool l, bool event, bool early,
                                  const uint32_t* required, size_t n, void* given, Logger* log, void* update_intermediate) {
  (void)name, (void)resources, (void)v, (void)l, (void)event, (void)early, (void)required, (void)n, (void)update_intermediate;
  logger = log;
  environment = given;
  return create(token);
}
void fmi3FreeInstance(void* c) { free(c); }
int fmi3EnterInitializationMode(void* c, bool t, double tolerance, double start, bool s, double stop) {
  (void)t, (void)tolerance, (void)start, (void)s, (void)stop;
  return c == NULL ? kError : kOk;
}
int fmi3ExitInitializationMode(void* c) {
  update(c);
  return kOk;
}
int fmi3Terminate(void* c) { return c == NULL ? kError : kOk; }
int fmi3GetFloat64(void* c, const uint32_t* r, size_t n, double* values, size_t m) {
  return n == m ? access_values(c, r, n, values, NULL) : kError;
}
int fmi3SetFloat64(void* c, const uint32_t* r, size_t n, const double* values, size_t m) {
  return n == m ? access_values(c, r, n, NULL, values) : kError;
}
int fmi3GetBoolean(void* c, const uint32_t* r, size_t n, bool* values, size_t m) {
  double value = 0;
  const int status = n == 1 && m == 1 ? access_values(c, r, n, &value, NULL) : kError;
  values[0] = value != 0;
  return status;
}
int fmi3SetBoolean(void* c, const uint32_t* r, size_t n, const bool* values, size_t m) {
  const double value = values[0];
  return n == 1 && m == 1 ? access_values(c, r, n, NULL, &value) : kError;
}
#ifndef WITHOUT_STEP
int fmi3DoStep(void* c, double time, double size, bool prior, bool* event, bool* terminate, bool* early, double* last) {
  (void)prior;
  const int status = step(c, time, size);
  *event = false;
  *terminate = HOSTILE == kEnds && ((Controller*)c)->tick == 200;
  *early = HOSTILE == kReturnsEarly && ((Controller*)c)->tick == 200;
  *last = time + size;
  if (status != kOk) logger(environment, status, "logStatusError", "gyro 7 has failed");
  return status;
}
#endif
#endif
