/* A controller on the wire of ROS 2, as a node on Cyclone DDS would be: hears /clock, /tf and /unlatch/sensors, and
 * flies bridge/examples/probe.yaml like the pilot: throttle open at 0.1 s, shut at 0.3 s. Exit code 1 if something was
 * not as it should be. It shares no code with the node, which is on Fast DDS; its types are made by idlc. */
#include <dds/dds.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ros2_messages.h"

typedef sensor_msgs_msg_dds__JointState_ joint_state;
typedef rosgraph_msgs_msg_dds__Clock_ clock_message;
typedef tf2_msgs_msg_dds__TFMessage_ tf_message;

/* The loopback interface alone, as with ROS_LOCALHOST_ONLY=1. */
static const char* const kNetwork =
    "<CycloneDDS><Domain Id=\"any\"><General><Interfaces><NetworkInterface name=\"lo\" "
    "multicast=\"true\"/></Interfaces>"
    "</General></Domain></CycloneDDS>";
static const dds_duration_t kPatience = DDS_SECS(60);

static dds_entity_t participant;
static int states, faults;
static double clock_s = -1, last_x = -1;

static dds_entity_t check(const char* what, dds_entity_t entity) {
  if (entity >= 0) return entity;
  fprintf(stderr, "controller: %s: %s\n", what, dds_strretcode(entity));
  exit(3);
}

static void expect(bool holds, const char* what) {
  if (!holds && faults++ == 0) fprintf(stderr, "controller: %s\n", what);
}

/* The quality of service that rclcpp gives topics: reliable, volatile, the last 10. */
static dds_entity_t open_topic(const char* name, const dds_topic_descriptor_t* type, bool writer) {
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_durability(qos, DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 10);
  const dds_entity_t topic = check(name, dds_create_topic(participant, type, name, NULL, NULL));
  const dds_entity_t entity = check(name, writer ? dds_create_writer(participant, topic, qos, NULL)
                                                 : dds_create_reader(participant, topic, qos, NULL));
  dds_delete_qos(qos);
  return entity;
}

/* The next message of a reader, or NULL; to be given back. */
static void* take(dds_entity_t reader) {
  void* sample = NULL;
  dds_sample_info_t info;
  while (dds_take(reader, &sample, &info, 1, 1) > 0) {
    if (info.valid_data) return sample;
    dds_return_loan(reader, &sample, 1);
    sample = NULL;
  }
  return NULL;
}

static bool is_matched(dds_entity_t reader) {
  dds_subscription_matched_status_t status;
  check("matches", dds_get_subscription_matched_status(reader, &status));
  return status.current_count > 0;
}

static void command(dds_entity_t writer, builtin_interfaces_msg_dds__Time_ stamp, const double* throttle) {
  char frame[] = "", name[] = "throttle";
  char* names[] = {name};
  double position[] = {throttle != NULL ? *throttle : 0};
  joint_state answer;
  memset(&answer, 0, sizeof answer);
  answer.header.stamp = stamp;
  answer.header.frame_id = frame;
  if (throttle != NULL) {
    answer.name._buffer = names;
    answer.name._length = answer.name._maximum = 1;
    answer.position._buffer = position;
    answer.position._length = answer.position._maximum = 1;
  }
  check("a command", dds_write(writer, &answer));
}

static void control(const joint_state* sensors, dds_entity_t writer) {
  static const char* const kNames[] = {"gyro.x", "gyro.y", "gyro.z"};
  static const double kOpen = 1, kShut = 0, kWrong = 0.5;
  ++states;
  expect(sensors->name._length == 3 && sensors->position._length == 3, "the gyro has not three values");
  for (uint32_t i = 0; i < sensors->name._length && i < 3; ++i)
    expect(strcmp(sensors->name._buffer[i], kNames[i]) == 0 && sensors->position._buffer[i] == 0,
           "the gyro is another");
  const builtin_interfaces_msg_dds__Time_ stamp = sensors->header.stamp;
  builtin_interfaces_msg_dds__Time_ of_another_state = stamp;
  ++of_another_state.nanosec;
  command(writer, of_another_state, &kWrong); /* not taken */
  const int ms = (int)(stamp.sec * 1000 + (int)(stamp.nanosec / 1000000));
  command(writer, stamp, ms == 100 ? &kOpen : ms == 300 ? &kShut : NULL);
}

static void hear(dds_entity_t clocks, dds_entity_t frames, dds_entity_t sensors, dds_entity_t commands) {
  void* sample;
  while ((sample = take(clocks)) != NULL) {
    const clock_message* message = sample;
    expect(message->clock.sec + 1e-9 * message->clock.nanosec >= clock_s, "the clock goes back");
    clock_s = message->clock.sec + 1e-9 * message->clock.nanosec;
    dds_return_loan(clocks, &sample, 1);
  }
  while ((sample = take(frames)) != NULL) {
    const tf_message* message = sample;
    expect(message->transforms._length == 1, "not one body");
    if (message->transforms._length == 1) {
      const geometry_msgs_msg_dds__TransformStamped_* body = message->transforms._buffer;
      expect(strcmp(body->header.frame_id, "inertial") == 0 && strcmp(body->child_frame_id, "probe") == 0,
             "other frames");
      expect(body->transform.rotation.w == 1 && body->transform.translation.y == 0, "another pose");
      last_x = body->transform.translation.x;
    }
    dds_return_loan(frames, &sample, 1);
  }
  while ((sample = take(sensors)) != NULL) {
    control(sample, commands);
    dds_return_loan(sensors, &sample, 1);
  }
}

int main(void) {
  check("the domain", dds_create_domain(0, kNetwork));
  participant = check("the participant", dds_create_participant(0, NULL, NULL));
  const dds_entity_t clocks = open_topic("rt/clock", &rosgraph_msgs_msg_dds__Clock__desc, false);
  const dds_entity_t frames = open_topic("rt/tf", &tf2_msgs_msg_dds__TFMessage__desc, false);
  const dds_entity_t sensors = open_topic("rt/unlatch/sensors", &sensor_msgs_msg_dds__JointState__desc, false);
  const dds_entity_t commands = open_topic("rt/unlatch/command", &sensor_msgs_msg_dds__JointState__desc, true);
  const dds_entity_t waitset = check("a wait set", dds_create_waitset(participant));
  check("a status", dds_set_status_mask(sensors, DDS_DATA_AVAILABLE_STATUS | DDS_SUBSCRIPTION_MATCHED_STATUS));
  check("a status", dds_waitset_attach(waitset, sensors, 0));

  const dds_time_t until = dds_time() + kPatience;
  dds_publication_matched_status_t hearers = {0};
  while (hearers.current_count == 0 || !is_matched(clocks) || !is_matched(frames) || !is_matched(sensors)) {
    if (dds_time() > until) return fprintf(stderr, "controller: nobody is on the wire\n"), 3;
    dds_sleepfor(DDS_MSECS(5));
    check("matches", dds_get_publication_matched_status(commands, &hearers));
  }
  printf("controller: everything is matched\n");
  fflush(stdout);
  while (is_matched(sensors)) {
    if (dds_waitset_wait(waitset, NULL, 0, kPatience) <= 0)
      return fprintf(stderr, "controller: the node is silent\n"), 3;
    hear(clocks, frames, sensors, commands);
  }
  expect(states >= 500, "some State has not come");
  expect(fabs(clock_s - 0.5) < 0.0015, "the clock has not come to the end");
  expect(fabs(last_x - 3) < 0.02, "the probe is elsewhere");
  printf("controller: %d states, clock %.3f s, x = %.6f m\n", states, clock_s, last_x);
  dds_delete(DDS_CYCLONEDDS_HANDLE);
  return faults > 0;
}
