/* unlatch as a C library (C99): load a scenario, command its channels, step it, read what it computes.
 *
 *   unlatch_simulation* sim;
 *   if (unlatch_load("scenario.yaml", NULL, &sim) < 0) { puts(unlatch_get_error(0)->text); return 1; }
 *   unlatch_set_channel(sim, 0, 1.0);
 *   unlatch_step(sim);
 *   unlatch_close(sim);
 *
 * Units are SI and radians. W is the inertial frame. Attitudes are quaternions w, x, y, z, body to inertial; positions
 * and velocities have inertial axes, angular velocities body axes.
 *
 * Every function returns a status: UNLATCH_OK, another status that is no error (> 0), or an error (< 0); after an error
 * unlatch_get_error() describes it to this thread, and nothing has changed. No C++ exception leaves the library.
 *
 * A handle may be used by any thread, by one at a time: a call on a handle in which another thread is at work gives
 * UNLATCH_ERROR_BUSY. Different handles do not hinder each other. A null, closed, or foreign handle gives
 * UNLATCH_ERROR_HANDLE. At most 16,384 handles are open at a time.
 *
 * unlatch_step(), unlatch_advance(), unlatch_set_channel() and unlatch_set_channels() allocate nothing, take no lock and
 * make no system call, unless the simulation judges, notices or records.
 *
 * ABI: symbols carry the version UNLATCH_0.1. Structs whose first member is `size` may grow at their end: the caller
 * sets it to sizeof of the struct that it knows. Enumerators keep their numbers. */
#ifndef UNLATCH_H_
#define UNLATCH_H_

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define UNLATCH_API __attribute__((visibility("default")))

/* --- Status and errors ------------------------------------------------------------------------------------------- */

typedef int32_t unlatch_status;
enum {
  UNLATCH_OK = 0,
  UNLATCH_EVENT = 1,             /* unlatch_advance() stopped after a tick in which events acted */
  UNLATCH_END = 2,               /* the recording that is replayed is at its end */
  UNLATCH_INTERRUPTED = 3,       /* unlatch_interrupt() was called */
  UNLATCH_UNRESOLVED = 4,        /* of a sample of a batch with UNLATCH_JUDGE: it ran to its end, but the step did not
                                    resolve something; its values are no results */
  UNLATCH_ERROR_ARGUMENT = -1,   /* a null pointer, an unknown number, a struct of no known size */
  UNLATCH_ERROR_HANDLE = -2,     /* a null, closed or foreign handle */
  UNLATCH_ERROR_BUSY = -3,       /* another thread is at work in this handle */
  UNLATCH_ERROR_SCENARIO = -4,   /* mistakes in the scenario or its overrides, each with its place */
  UNLATCH_ERROR_FILE = -5,       /* a file cannot be read, written, or is not what it should be */
  UNLATCH_ERROR_RANGE = -6,      /* an index, a tick or a value outside its range, or not finite */
  UNLATCH_ERROR_FAULT = -7,      /* the step cannot be made; the last good state is kept */
  UNLATCH_ERROR_ORDER = -8,      /* this call is not possible now, or not with the flags of unlatch_load() */
  UNLATCH_ERROR_STATE = -9,      /* what is restored is no state of this model */
  UNLATCH_ERROR_DIFFERENCE = -10, /* the replay differs from the recording */
  UNLATCH_ERROR_MEMORY = -11,    /* no memory, or no free handle */
  UNLATCH_ERROR_INTERNAL = -12   /* a defect of the library */
};

typedef struct unlatch_error {
  size_t size;          /* size of this struct */
  unlatch_status status;
  int32_t line, column; /* in `file`, from 1; 0: the file as a whole, or none */
  const char* text;     /* the fault and its correction, with its place; never null */
  const char* file;     /* name as given; "" if the error does not concern a file */
  const char* key;      /* key in the scenario: "bodies.core.mass"; "" if it does not concern a key */
} unlatch_error;

/* The errors of this thread's latest call that failed; a scenario may have several. Null beyond the last. Valid until
 * this thread's next call that fails. */
UNLATCH_API const unlatch_error* unlatch_get_error(size_t index);
UNLATCH_API size_t unlatch_count_errors(void);
/* Text of a status: "closed or foreign handle". Never null. */
UNLATCH_API const char* unlatch_get_status_text(unlatch_status status);
/* Version of the library: "0.1.0". */
UNLATCH_API const char* unlatch_get_version(void);

/* --- Loading ------------------------------------------------------------------------------------------------------ */

typedef struct unlatch_simulation unlatch_simulation; /* one run of a scenario, or the replay of a recording */
typedef struct unlatch_batch unlatch_batch;           /* many samples of a scenario, run by threads */

enum {
  /* Requirements are judged and clearances computed at each step. It costs several times the step, and allocates. */
  UNLATCH_JUDGE = 1,
  /* What the step does not resolve is noticed, see unlatch_get_findings(); it allocates. UNLATCH_JUDGE does so too.
   * Without either nobody looks: whatever the step gets wrong, calls return UNLATCH_OK. */
  UNLATCH_NOTICE = 2
};

typedef struct unlatch_options {
  size_t size;                  /* size of this struct */
  const char* const* overrides; /* "PATH=VALUE", as --set takes them, applied in this order; may be null */
  size_t override_count;
  uint32_t flags;               /* UNLATCH_JUDGE | UNLATCH_NOTICE, either, or 0; a batch takes UNLATCH_JUDGE */
  uint32_t event_capacity;      /* number of stored events, see unlatch_get_events(); 0: 4096 */
} unlatch_options;

/* Loads a scenario from a file, or from a text that includes no other file. `name`: name of the text in messages.
 * `options` may be null. *simulation is null after an error. */
UNLATCH_API unlatch_status unlatch_load(const char* path, const unlatch_options* options,
                                        unlatch_simulation** simulation);
UNLATCH_API unlatch_status unlatch_load_text(const char* text, size_t length, const char* name,
                                             const unlatch_options* options, unlatch_simulation** simulation);
/* Opens a recording (*.log): its steps apply the recorded commands, and each is compared with the recorded hash. Such a
 * simulation accepts no commands, restores nothing and cannot be recorded. Overrides are those of the recording. */
UNLATCH_API unlatch_status unlatch_open_recording(const char* path, const unlatch_options* options,
                                                  unlatch_simulation** simulation);
/* Ends a recording in progress, and frees all memory that pointers of this simulation refer to. */
UNLATCH_API unlatch_status unlatch_close(unlatch_simulation* simulation);

/* --- Contents ------------------------------------------------------------------------------------------------------ */

enum {
  UNLATCH_BODY = 0,
  UNLATCH_JOINT = 1,
  UNLATCH_CHANNEL = 2,
  UNLATCH_SENSOR = 3,
  UNLATCH_SIGNAL = 4,
  UNLATCH_EVENT_KIND = 5, /* events that the scenario describes */
  UNLATCH_REQUIREMENT = 6,
  UNLATCH_CLEARANCE = 7,  /* watched pairs of bodies or of their shapes */
  UNLATCH_QUANTITY = 8,   /* quantities for requirements: "reaction.nose1.x" */
  UNLATCH_CONSTANT = 9,   /* the scenario's own constants; "constants.NAME=VALUE" overrides one */
  UNLATCH_NUMBER = 10     /* literal numbers of the scenario, by their path; "PATH=VALUE" overrides one. Numbers that
                             follow from constants are excluded */
};

typedef struct unlatch_item {
  size_t size;           /* size of this struct */
  const char* name;      /* unique in its list; clearances: "core – booster1" */
  const char* unit;      /* unit of its values, SI; "" if it has none, or several */
  const char* text;      /* events: their subject; requirements: their text; joints: "core – nose"; quantities: their
                            text in a requirement; constants: their path, "constants.NAME"; else "" */
  int32_t first, width;  /* sensors: index of the first value, number of values; joints: 0, number of modes */
  int32_t a, b;          /* joints: base and follower; clearances: the bodies; -1: the ground; else -1 */
  double initial;        /* channels; constants, numbers: the value */
  double minimum, maximum; /* channels: their range; requirements: the limits, infinite where there is none */
  double safe;           /* channels */
} unlatch_item;

/* Number of items of a kind. */
UNLATCH_API unlatch_status unlatch_count(unlatch_simulation* simulation, int32_t kind, size_t* count);
/* Fills item->size bytes of *item. Texts are valid until the simulation is closed. */
UNLATCH_API unlatch_status unlatch_describe(unlatch_simulation* simulation, int32_t kind, size_t index,
                                            unlatch_item* item);
/* Finds an item. Events are found by "name:subject", or by their name if it is unique. */
UNLATCH_API unlatch_status unlatch_find(unlatch_simulation* simulation, int32_t kind, const char* name, size_t* index);
/* Name of a mode of a joint. */
UNLATCH_API unlatch_status unlatch_get_mode_name(unlatch_simulation* simulation, size_t joint, size_t mode,
                                                 const char** name);
/* Name of the scenario; its step and the end of its run, s. Any of the pointers may be null. */
UNLATCH_API unlatch_status unlatch_get_scenario(unlatch_simulation* simulation, const char** name, double* dt,
                                                double* until);

/* --- Commands and steps -------------------------------------------------------------------------------------------- */

/* Sets the value of a channel from the next step on. Refused outside the channel's range. */
UNLATCH_API unlatch_status unlatch_set_channel(unlatch_simulation* simulation, size_t channel, double value);
/* Sets the values of `count` channels from `first` on: all of them, or none if one is refused. */
UNLATCH_API unlatch_status unlatch_set_channels(unlatch_simulation* simulation, size_t first, size_t count,
                                                const double* values);

/* Makes one tick. */
UNLATCH_API unlatch_status unlatch_step(unlatch_simulation* simulation);

enum {
  UNLATCH_STOP_AT_EVENTS = 1 /* stop after a tick in which events acted */
};
/* Makes `ticks` ticks, or fewer if an event, an interruption, an error or the end of a recording comes before. *done,
 * which may be null, is the number of ticks made. */
UNLATCH_API unlatch_status unlatch_advance(unlatch_simulation* simulation, uint64_t ticks, uint32_t flags,
                                           uint64_t* done);
/* Ends unlatch_advance() or unlatch_run_batch() of another thread after the present tick; callable from any thread, and
 * from a signal handler. If no such call is running, it ends the next one. */
UNLATCH_API unlatch_status unlatch_interrupt(void* handle);

/* Number of the present tick. */
UNLATCH_API unlatch_status unlatch_get_tick(unlatch_simulation* simulation, int64_t* tick);
/* Time of the present state, s: tick · dt. */
UNLATCH_API unlatch_status unlatch_get_time(unlatch_simulation* simulation, double* time);
/* Hash of every bit of the state; the one that `unlatch run` prints. */
UNLATCH_API unlatch_status unlatch_get_hash(unlatch_simulation* simulation, uint64_t* hash);

/* --- Results ------------------------------------------------------------------------------------------------------- */

enum {
  UNLATCH_POSITIONS = 0,        /* bodies × 3, m */
  UNLATCH_ATTITUDES = 1,        /* bodies × 4 */
  UNLATCH_VELOCITIES = 2,       /* bodies × 3, m/s */
  UNLATCH_ANGULAR_VELOCITIES = 3, /* bodies × 3, body axes, rad/s */
  UNLATCH_MODAL_COORDINATES = 4,  /* body number `index`: 1 × modes, 1; no columns if it is rigid */
  UNLATCH_JOINT_MODES = 5,      /* joints × 1, int64: number of the present mode */
  UNLATCH_REACTIONS = 6,        /* joint number `index`: 1 × 6, rows x y z rot_x rot_y rot_z, on the follower; N, N m; 0
                                   for inactive rows */
  UNLATCH_SENSORS = 7,          /* values × 1, in the units of the sensors: as last sampled, with
                                   the sensors' errors (`errors` of the scenario), held between samples; without errors
                                   the true values, which the columns `sensor.NAME` of exports always have */
  UNLATCH_SIGNALS = 8,          /* signals × 1 */
  UNLATCH_CHANNELS = 9,         /* channels × 1: the commanded values */
  UNLATCH_CLEARANCES = 10,      /* pairs × 1, m, negative: the depth of an overlap; needs UNLATCH_JUDGE */
  UNLATCH_RECEIVED = 11         /* as UNLATCH_SENSORS, but as flight software received them: faults distort them, States
                                   are dropped or late. No rows unless a session is replayed */
};
enum { UNLATCH_DOUBLE = 0, UNLATCH_INT64 = 1 };

/* Array in the simulation's own memory: read only, and at these addresses until it is closed. */
typedef struct unlatch_array {
  size_t size;                         /* size of this struct */
  const void* data;                    /* address of row 0, column 0 */
  int32_t type;                        /* UNLATCH_DOUBLE or UNLATCH_INT64 */
  int32_t reserved;
  size_t rows, columns;
  ptrdiff_t row_stride, column_stride; /* bytes */
} unlatch_array;

/* Returns an array. `index`: number of the body or joint if the array belongs to one; else 0. */
UNLATCH_API unlatch_status unlatch_get_array(unlatch_simulation* simulation, int32_t which, size_t index,
                                             unlatch_array* array);
/* Element of an array of UNLATCH_DOUBLE. */
static inline double unlatch_get_number(const unlatch_array* array, size_t row, size_t column) {
  return *(const double*)((const char*)array->data + (ptrdiff_t)row * array->row_stride +
                          (ptrdiff_t)column * array->column_stride);
}

/* An event that acted. */
typedef struct unlatch_event {
  double time;   /* s, inside the step */
  int64_t tick;  /* tick of the state before that step */
  int64_t event; /* number among UNLATCH_EVENT_KIND */
} unlatch_event;

/* Returns the events since the beginning, or since the latest reset or restoration; the first event_capacity of them
 * are stored. *events keeps its address, *count grows. `lost`, which may be null: number of events beyond the
 * capacity. */
UNLATCH_API unlatch_status unlatch_get_events(unlatch_simulation* simulation, const unlatch_event** events,
                                              size_t* count, uint64_t* lost);

/* The verdict on a requirement so far. */
typedef struct unlatch_verdict {
  int32_t evaluated;           /* 1; 0: `why` gives the reason */
  int32_t met;                 /* 1 or 0; an unresolved one has `evaluated` and `met` 0 */
  double value, limit, margin; /* in the requirement's unit; margin < 0: not met */
  double time;                 /* time of the value, s */
  const char* why;             /* "event 'release:booster1' did not occur", "unresolved: contact …"; else "" */
} unlatch_verdict;

/* Returns one verdict for each requirement, in their order; needs UNLATCH_JUDGE. *verdicts keeps its address; its
 * contents are those of the latest call. */
UNLATCH_API unlatch_status unlatch_judge(unlatch_simulation* simulation, const unlatch_verdict** verdicts,
                                         size_t* count);

/* How well the value of a verdict is known. */
typedef struct unlatch_certainty {
  double uncertainty; /* in the requirement's unit: how far the value may be wrong, between steps and by their errors;
                         infinity: not known, since the step does not resolve what it depends on */
  int32_t at_ticks;   /* 1: the value is that of a tick or an event, and may be beyond it in between; else 0 */
} unlatch_certainty;

/* Returns one for each verdict of the latest unlatch_judge(), in their order; before it none. *certainties keeps its
 * address; its contents are those of the latest unlatch_judge(). */
UNLATCH_API unlatch_status unlatch_get_certainties(unlatch_simulation* simulation,
                                                   const unlatch_certainty** certainties, size_t* count);

/* A fact that one should know before one trusts the results. */
typedef struct unlatch_finding {
  int32_t of_run;          /* 0: of the scenario, as `unlatch check` prints it; 1: noticed at a step */
  int32_t unresolved;      /* 1: results that depend on its subject are no results */
  double time, worst_time; /* of_run: when it was noticed first, and of its worst value, s; else 0 */
  const char* name;        /* its kind: "contact", "profile", "overlap" */
  const char* subject;     /* of_run: name of the body, element, joint …; else the part of the scenario,
                              "element 'push'"; "" if it concerns all of it */
  const char* text;        /* the fact, and what would mend it */
} unlatch_finding;

/* Returns the findings about the scenario, and those about the run since its beginning, or since the latest reset or
 * restoration; the latter need UNLATCH_JUDGE or UNLATCH_NOTICE. UNLATCH_NOTICE does not audit the energy and the drift
 * of joints. The first call may take as long as some hundred steps. Valid until this simulation's next call. */
UNLATCH_API unlatch_status unlatch_get_findings(unlatch_simulation* simulation, const unlatch_finding** findings,
                                                size_t* count);

/* Linear model about the present state: dx/dt = A x + B u, y = C x + D u. x: deviations of the free coordinates, then of
 * their speeds; u: of all channels; y: of all sensors' values, then of all quantities. */
typedef struct unlatch_linear_model {
  double time; /* of the state, s */
  size_t state_count, input_count, output_count;
  /* Names and units: "joint.hinge1.rot_z", "rad", "rate.joint.hinge1.rot_z", "rad/s"; "sensor.gyro.x". */
  const char *const *states, *const *state_units, *const *inputs, *const *input_units, *const *outputs,
      *const *output_units;
  const double *a, *b, *c, *d;                         /* by rows */
  const double *a_error, *b_error, *c_error, *d_error; /* estimated errors of the entries, by rows */
} unlatch_linear_model;

/* Linearises about the present state in the present modes; the state does not change. It takes as long as some four
 * evaluations for each state and channel. Valid until this simulation's next call. */
UNLATCH_API unlatch_status unlatch_linearize(unlatch_simulation* simulation, const unlatch_linear_model** model);

/* Poles and steady-state gains of a linear model. */
typedef struct unlatch_linear_response {
  size_t pole_count;
  const double* poles; /* real and imaginary part of each, 1/s, by their size */
  /* D - C A^-1 B and its estimated errors, output_count by input_count, by rows: what an output changes by in the end, for
   * each unit of a constant input, if the motions decay. INFINITY where the input moves the output without end, by a motion
   * of a pole at 0. */
  const double *gains, *gains_error;
  const double* poles_error; /* estimated, of each pole, 1/s: a pole whose size is not above it is not distinct from 0 */
} unlatch_linear_response;

/* Returns those of the model that the latest unlatch_linearize() made, which stays valid with it; UNLATCH_ERROR_ORDER
 * before the first. */
UNLATCH_API unlatch_status unlatch_get_linear_response(unlatch_simulation* simulation,
                                                       const unlatch_linear_response** response);

/* Margins of a loop, each the least over all crossings up to half the sampling frequency, at which the gain may
 * change ten thousand times at most; value and frequency (rad/s) are NaN without such a crossing. */
typedef struct unlatch_loop_margins {
  int stable;                   /* 1: the closed loop is */
  double gain, gain_frequency;  /* factor above 1 that the loop's gain may grow by */
  double drop, drop_frequency;  /* factor below 1 that it may fall to */
  double phase, phase_frequency; /* rad */
  double delay, delay_frequency; /* s, beside the loop's own */
} unlatch_loop_margins;

/* Returns the margins of negative feedback around the model that the latest unlatch_linearize() made: `loop` is written
 * as for `unlatch linearize --loop`, "torque=12*sensor.angle+30*sensor.gyro.z". period: s, outputs are sampled and the
 * channel is held; 0: continuous. delay: s, from the sample to the command, a whole number of periods or not.
 * UNLATCH_ERROR_ORDER before the first model; UNLATCH_ERROR_ARGUMENT for a loop that cannot be read, names what the model
 * has not, or is not resolved: a period below 1e-9 s, or a delay that is too long beside the motion. */
UNLATCH_API unlatch_status unlatch_calc_margins(unlatch_simulation* simulation, const char* loop, double period,
                                                double delay, unlatch_loop_margins* margins);

/* --- States -------------------------------------------------------------------------------------------------------- */

/* Saves all data that determine the further run, as *needed bytes; written if `capacity` is that or more. `buffer` may
 * be null with `capacity` 0, to ask for the size, which never changes. The state fits a simulation of the same scenario
 * with the same overrides, also in another process. */
UNLATCH_API unlatch_status unlatch_save(unlatch_simulation* simulation, void* buffer, size_t capacity, size_t* needed);
/* Restores a saved state. Events, verdicts and clearances begin anew there. Where a simulation with UNLATCH_NOTICE or
 * UNLATCH_JUDGE had saved it after something that the step did not resolve, all that follows is unresolved: the finding
 * `start`. */
UNLATCH_API unlatch_status unlatch_restore(unlatch_simulation* simulation, const void* buffer, size_t length);
/* Returns to the state at which the simulation was loaded. */
UNLATCH_API unlatch_status unlatch_reset(unlatch_simulation* simulation);

/* --- Recordings ---------------------------------------------------------------------------------------------------- */

/* Records from the present tick on, for `unlatch replay`, `report`, `export` and unlatch_open_recording(). */
UNLATCH_API unlatch_status unlatch_start_recording(unlatch_simulation* simulation, const char* path);
/* Completes the file. Returns an error if it could not be written. */
UNLATCH_API unlatch_status unlatch_stop_recording(unlatch_simulation* simulation);

/* --- Batches ------------------------------------------------------------------------------------------------------- */

/* Opens a batch: samples of one scenario, each with its own overrides besides those of `options`. Channels keep their
 * initial values. UNLATCH_JUDGE gives verdicts. Without it nobody looks whether the step resolves a sample: its status
 * is UNLATCH_OK then, however wrong its numbers are. With it such a sample has the status UNLATCH_UNRESOLVED. */
UNLATCH_API unlatch_status unlatch_open_batch(const char* path, const unlatch_options* options, unlatch_batch** batch);
UNLATCH_API unlatch_status unlatch_add_sample(unlatch_batch* batch, const char* const* overrides, size_t count);
/* Runs all samples that have not been run, to `until` s, or for 0 to the end in the scenario, on `threads` threads, 0
 * for one on each processor. A sample that cannot be loaded or stepped is no error of the batch: its status shows it.
 * After UNLATCH_INTERRUPTED another call continues. */
UNLATCH_API unlatch_status unlatch_run_batch(unlatch_batch* batch, double until, size_t threads);

enum {
  UNLATCH_SAMPLE_STATUS = 0,  /* samples × 1, int64: unlatch_status; UNLATCH_INTERRUPTED: not run yet */
  UNLATCH_SAMPLE_TICKS = 1,   /* samples × 1, int64: ticks made */
  UNLATCH_SAMPLE_HASHES = 2,  /* samples × 1, int64: hash of the last state */
  UNLATCH_SAMPLE_EVENTS = 3,  /* samples × events, s: first time of each; NaN: never */
  UNLATCH_SAMPLE_VALUES = 4,  /* samples × requirements: values; NaN: not evaluated. Needs UNLATCH_JUDGE */
  UNLATCH_SAMPLE_MARGINS = 5, /* likewise margins */
  UNLATCH_SAMPLE_BODIES = 6   /* samples × 13 bodies, at the end: position, attitude, velocity, angular velocity of
                                 each */
};
/* Returns results; valid until the next unlatch_add_sample() or unlatch_close_batch(). */
UNLATCH_API unlatch_status unlatch_get_batch_array(unlatch_batch* batch, int32_t which, unlatch_array* array);
/* Returns the reason of a sample's failure; "" if it did not fail. Valid as long as the results. */
UNLATCH_API unlatch_status unlatch_get_sample_text(unlatch_batch* batch, size_t sample, const char** text);
/* Items of the scenario, as from unlatch_count() and unlatch_describe(). */
UNLATCH_API unlatch_status unlatch_count_in_batch(unlatch_batch* batch, int32_t kind, size_t* count);
UNLATCH_API unlatch_status unlatch_describe_in_batch(unlatch_batch* batch, int32_t kind, size_t index,
                                                     unlatch_item* item);
UNLATCH_API unlatch_status unlatch_close_batch(unlatch_batch* batch);

#ifdef __cplusplus
}
#endif

#endif /* UNLATCH_H_ */
