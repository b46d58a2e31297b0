/* Flight software in C99 over Cyclone DDS, against nothing but the IDL: takes part in a lockstep session of probe.yaml
 * as 'pilot', opens the throttle at tick 100 and shuts it at tick 300. */
#include <dds/dds.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "unlatch.h"

enum { kParticipant = 1001, kOpenAt = 100, kShutAt = 300 };
static const dds_duration_t kPatience = DDS_SECS(30);
static const dds_duration_t kGone = DDS_SECS(2); /* a simulator that has been silent for so long is gone */

/* Loopback alone, as the simulator's default: there is no multicast, so that each side must know where to look. */
static const char* const kNetwork =
    "<CycloneDDS><Domain Id=\"any\"><General><Interfaces><NetworkInterface name=\"lo\" "
    "multicast=\"false\"/></Interfaces>"
    "<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
    "<MaxAutoParticipantIndex>99</MaxAutoParticipantIndex><Peers><Peer Address=\"127.0.0.1\"/></Peers></Discovery>"
    "</Domain></CycloneDDS>";

static dds_entity_t participant;
static dds_entity_t hellos, catalog, states;         /* received */
static dds_entity_t hello_acks, commands, step_acks; /* sent */

static int64_t session;   /* 0: none yet */
static dds_time_t heard;  /* time at which something of it came last */
static bool warned;       /* of another simulator */
static int throttle = -1; /* the channel's index */
static unlatch_HelloAck introduction;
static int64_t answered_tick = -1, last_command;
static unlatch_Command answer; /* the command of answered_tick */
static int answer_count;

/* Cyclone's threads, and with security those of its plugins, must have ended before the process does: everything is
 * deleted on every way out. */
static int leave(int code) {
  dds_delete(DDS_CYCLONEDDS_HANDLE);
  return code;
}

static dds_entity_t check(const char* what, dds_entity_t entity) {
  if (entity < 0) {
    fprintf(stderr, "pilot: %s: %s\n", what, dds_strretcode(entity));
    exit(leave(3));
  }
  return entity;
}

/* Everything is reliable. What must outlive the moments in which both sides discover each other is transient-local. */
static dds_qos_t* make_qos(bool transient, int depth) {
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, depth);
  if (transient) {
    dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
    dds_qset_durability_service(qos, 0, DDS_HISTORY_KEEP_LAST, 64, DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED,
                                DDS_LENGTH_UNLIMITED);
    dds_qset_lifespan(qos, DDS_SECS(2)); /* the next simulator shall not receive old commands */
  }
  return qos;
}

static dds_entity_t open_writer(const char* name, const dds_topic_descriptor_t* type, bool transient) {
  dds_qos_t* qos = make_qos(transient, 64);
  const dds_entity_t topic = check(name, dds_create_topic(participant, type, name, NULL, NULL));
  const dds_entity_t writer = check(name, dds_create_writer(participant, topic, qos, NULL));
  dds_delete_qos(qos);
  return writer;
}

static dds_entity_t open_reader(const char* name, const dds_topic_descriptor_t* type, bool transient,
                                dds_entity_t waitset) {
  dds_qos_t* qos = make_qos(transient, 256);
  const dds_entity_t topic = check(name, dds_create_topic(participant, type, name, NULL, NULL));
  const dds_entity_t reader = check(name, dds_create_reader(participant, topic, qos, NULL));
  dds_delete_qos(qos);
  dds_waitset_attach(waitset, dds_create_readcondition(reader, DDS_ANY_STATE), 0);
  return reader;
}

static bool take(dds_entity_t reader, void* message) {
  dds_sample_info_t info;
  while (dds_take(reader, &message, &info, 1, 1) == 1) {
    if (info.valid_data) return true;
  }
  return false;
}

static void introduce(void) {
  if (session == 0 || throttle < 0) return;
  dds_write(hello_acks, &introduction);
  ++introduction.sequence;
}

/* Stays with its session, and says so once. */
static void warn_of_other(const unlatch_Hello* hello) {
  if (warned) return;
  warned = true;
  fprintf(stderr, "pilot: another simulator is heard, session %lld; stays with session %lld\n",
          (long long)hello->session, (long long)session);
}

static void hear_hello(const unlatch_Hello* hello) {
  if (hello->status >= unlatch_RunStatus_kDone) return; /* kept from a session that is over */
  if (hello->session != session) {
    if (session != 0 && dds_time() - heard < kGone) {
      warn_of_other(hello);
      return;
    }
    memset(&introduction, 0, sizeof introduction);
    introduction.session = session = hello->session;
    introduction.schema_hash = unlatch_kSchemaHash;
    introduction.protocol = unlatch_kProtocolVersion;
    introduction.model_hash = hello->model_hash;
    introduction.dt_ns = hello->dt_ns;
    introduction.participant = kParticipant;
    introduction.status = unlatch_AckStatus_kReady;
    memcpy(introduction.name, "pilot", sizeof "pilot");
    throttle = -1;
    answered_tick = -1;
    last_command = 0;
  }
  heard = dds_time();
  introduce();
}

static void hear_catalog(const unlatch_Catalog* item) {
  if (item->session != session || item->kind != unlatch_CatalogKind_kChannel) return;
  if (strcmp((const char*)item->name, "throttle") != 0) return;
  const bool news = throttle < 0;
  throttle = item->index;
  if (news) introduce();
}

/* The decision from a state, for which flight software is there. False: nothing to command. */
static bool decide(const unlatch_State* state, double* value) {
  *value = state->tick == kOpenAt ? 1 : 0;
  return state->tick == kOpenAt || state->tick == kShutAt;
}

/* A State that is resent is answered again, with the same numbers. False: the session has ended. */
static bool hear_state(const unlatch_State* state) {
  unlatch_StepAck ack;
  if (state->session != session || throttle < 0 || state->part != 0) return true;
  heard = dds_time();
  if (state->status >= unlatch_RunStatus_kDone) return false;
  if (state->tick < answered_tick) return true;
  if (state->tick > answered_tick) {
    answered_tick = state->tick;
    answer_count = decide(state, &answer.value) ? 1 : 0;
    answer.session = session;
    answer.sequence = last_command += answer_count;
    answer.tick = state->tick;
    answer.valid_until_tick = -1;
    answer.participant = kParticipant;
    answer.channel = throttle;
  }
  if (answer_count > 0) dds_write(commands, &answer);
  ack.session = session;
  ack.sequence = state->sequence;
  ack.tick = state->tick;
  ack.last_command = last_command;
  ack.participant = kParticipant;
  ack.command_count = answer_count;
  dds_write(step_acks, &ack);
  return true;
}

int main(void) {
  static unlatch_Hello hello;
  static unlatch_Catalog item;
  static unlatch_State state;
  dds_entity_t waitset;
  /* CYCLONEDDS_URI, an identity of DDS Security for instance, takes the place of our network. */
  if (getenv("CYCLONEDDS_URI") == NULL) check("domain", dds_create_domain(0, kNetwork));
  participant = check("participant", dds_create_participant(0, NULL, NULL));
  waitset = check("waitset", dds_create_waitset(participant));
  hellos = open_reader("unlatch_Hello", &unlatch_Hello_desc, true, waitset);
  catalog = open_reader("unlatch_Catalog", &unlatch_Catalog_desc, true, waitset);
  states = open_reader("unlatch_State", &unlatch_State_desc, false, waitset);
  hello_acks = open_writer("unlatch_HelloAck", &unlatch_HelloAck_desc, true);
  commands = open_writer("unlatch_Command", &unlatch_Command_desc, true);
  step_acks = open_writer("unlatch_StepAck", &unlatch_StepAck_desc, false);

  while (dds_waitset_wait(waitset, NULL, 0, kPatience) > 0) {
    /* States first: they show that our simulator is still there. */
    while (take(states, &state)) {
      if (hear_state(&state)) continue;
      printf("pilot: the session ended at tick %lld, x = %.6f m\n", (long long)state.tick, state.bodies[0].x);
      return leave(state.status == unlatch_RunStatus_kDone ? 0 : 1);
    }
    while (take(hellos, &hello)) hear_hello(&hello);
    while (take(catalog, &item)) hear_catalog(&item);
  }
  fprintf(stderr, "pilot: the simulator is silent\n");
  return leave(1);
}
