// Watches the demo move with nothing but DDS, as a program in C++ without ROS 2: watch TOPIC DOMAIN
#include <cstdlib>
#include <iostream>

#include <dds/dds.h>

#include "state.h"

// A handle, or the end of the program with the reason.
static dds_entity_t
sound(dds_entity_t entity, const char *what)
{
  if (entity < 0) {
    std::cerr << what << ": " << dds_strretcode(-entity) << std::endl;
    std::exit(1);
  }
  return entity;
}

int
main(int argc, char *argv[])
{
  if (argc != 3) {
    std::cerr << "usage: watch TOPIC DOMAIN" << std::endl;
    return 2;
  }
  const auto domain = static_cast<dds_domainid_t>(std::strtoul(argv[2], nullptr, 10));
  dds_entity_t participant = sound(dds_create_participant(domain, nullptr, nullptr), "participant");
  dds_entity_t topic =
      sound(dds_create_topic(participant, &demo_msg_dds__State__desc, argv[1], nullptr, nullptr), "topic");

  // As nodes of ROS 2 read by default: reliable, and the ten latest samples.
  dds_qos_t *qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 10);
  dds_entity_t reader = sound(dds_create_reader(participant, topic, qos, nullptr), "reader");
  dds_delete_qos(qos);

  dds_entity_t waiting = sound(dds_create_waitset(participant), "wait set");
  dds_entity_t fresh = sound(dds_create_readcondition(reader, DDS_ANY_STATE), "condition");
  dds_waitset_attach(waiting, fresh, 0);
  for (bool watching = false;;) {
    dds_waitset_wait(waiting, nullptr, 0, DDS_INFINITY);
    demo_msg_dds__State_ state = {};
    void *samples[] = {&state};
    dds_sample_info_t info;
    while (dds_take(reader, samples, &info, 1, 1) > 0) {
      if (!info.valid_data) {
        continue;
      }
      if (!watching) {
        std::cout << "watching" << std::endl;
        watching = true;
      }
      if (state.position == 0.25) {
        std::cout << "arrived at " << state.velocity << " m/s" << std::endl;
        dds_delete(participant);
        return 0;
      }
    }
  }
}
