/*
 * A middleware in a library of its own: a board in memory, on which components of one process
 * exchange samples. docs/plugins.md explains it. */
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "genom3/middleware.h"

struct genom_mw_backend { char *board; }; /* those with the same options see each other */
struct genom_mw_publisher { struct port *port; };
struct genom_mw_subscription { struct port *port; void *to; genom_mw_subscription *next; };

struct port { /* one that has an open end */
  char *at, *type, *digest;
  int has_writer;
  void *last; /* its last value, for readers that come later */
  size_t len;
  genom_mw_subscription *readers;
  struct port *next;
};

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static struct port *ports;
static const genom_mw_host *host; /* the same for all backends of this library */

static char *copy(genom_mw_str s) { return strndup(s.len ? s.ptr : "", s.len); }

/* Finds or makes the port, if its type is this one. The caller holds the lock. */
static genom_mw_code find(genom_mw_backend *backend, const genom_mw_port *wanted,
                          struct port **found, genom_mw_error *error)
{
  char at[1024], *digest = copy(wanted->type->digest);
  snprintf(at, sizeof at, "%s %.*s/%.*s", backend->board, (int)wanted->at.instance.len,
           wanted->at.instance.ptr, (int)wanted->at.name.len, wanted->at.name.ptr);
  struct port *port = ports;
  while (port && strcmp(port->at, at)) port = port->next;
  if (!port) {
    port = calloc(1, sizeof *port);
    *port = (struct port){ .at = strdup(at), .type = copy(wanted->type->name),
                           .digest = strdup(digest), .next = ports };
    ports = port;
  }
  *found = port;
  int differs = strcmp(port->digest, digest);
  free(digest);
  if (!differs) return GENOM_MW_OK;
  error->len = (size_t)snprintf(error->text, error->room, "%s (%s)", port->type, port->digest);
  return GENOM_MW_TYPE_MISMATCH;
}

/* Frees a port that has no end any more. The caller holds the lock. */
static void leave(struct port *port)
{
  if (port->has_writer || port->readers) return;
  struct port **at = &ports;
  while (*at != port) at = &(*at)->next;
  *at = port->next;
  free(port->at), free(port->type), free(port->digest), free(port->last), free(port);
}

static genom_mw_code board_open(const genom_mw_host *given, genom_mw_str options,
                                genom_mw_backend **backend, genom_mw_error *error)
{
  (void)error, host = given; /* whatever the options are, they name a board */
  *backend = malloc(sizeof **backend);
  (*backend)->board = copy(options);
  return GENOM_MW_OK;
}

static void board_close(genom_mw_backend *backend) { free(backend->board), free(backend); }

static genom_mw_code board_publisher(genom_mw_backend *backend, const genom_mw_port *wanted,
                                     genom_mw_publisher **made, genom_mw_error *error)
{
  struct port *port;
  pthread_mutex_lock(&lock);
  genom_mw_code code = find(backend, wanted, &port, error);
  if (code == GENOM_MW_OK && port->has_writer) code = GENOM_MW_TAKEN;
  if (code == GENOM_MW_OK) {
    port->has_writer = 1;
    *made = malloc(sizeof **made);
    (*made)->port = port;
  }
  pthread_mutex_unlock(&lock);
  return code;
}

static genom_mw_code board_publish(genom_mw_publisher *publisher, genom_mw_bytes sample)
{
  struct port *port = publisher->port;
  pthread_mutex_lock(&lock);
  port->last = realloc(port->last, sample.len);
  memcpy(port->last, sample.ptr, port->len = sample.len);
  for (genom_mw_subscription *one = port->readers; one; one = one->next)
    host->sample(one->to, sample); /* copies it, and never calls back */
  pthread_mutex_unlock(&lock);
  return GENOM_MW_OK;
}

static void board_close_publisher(genom_mw_publisher *publisher)
{
  struct port *port = publisher->port;
  pthread_mutex_lock(&lock);
  port->has_writer = 0;
  free(port->last);
  port->last = NULL;
  leave(port);
  pthread_mutex_unlock(&lock);
  free(publisher);
}

static genom_mw_code board_subscription(genom_mw_backend *backend, const genom_mw_port *wanted,
                                   void *to, genom_mw_subscription **made, genom_mw_error *error)
{
  struct port *port;
  pthread_mutex_lock(&lock);
  genom_mw_code code = find(backend, wanted, &port, error);
  if (code == GENOM_MW_OK) {
    *made = malloc(sizeof **made);
    **made = (genom_mw_subscription){ port, to, port->readers };
    port->readers = *made;
    if (port->last) host->sample(to, (genom_mw_bytes){ port->last, port->len });
  }
  pthread_mutex_unlock(&lock);
  if (code != GENOM_MW_OK) host->release(to);
  return code;
}

static void board_close_subscription(genom_mw_subscription *subscription)
{
  pthread_mutex_lock(&lock);
  genom_mw_subscription **at = &subscription->port->readers;
  while (*at != subscription) at = &(*at)->next;
  *at = subscription->next;
  leave(subscription->port);
  pthread_mutex_unlock(&lock); /* from here on no publish sees it */
  host->release(subscription->to);
  free(subscription);
}

const genom_mw_plugin genom_middleware_plugin = {
  .size = sizeof(genom_mw_plugin), .major = GENOM_MW_MAJOR, .minor = GENOM_MW_MINOR,
  .name = GENOM_MW_STR("board"), .version = GENOM_MW_STR("board 1"),
  .capabilities = GENOM_MW_VARIABLE, .open = board_open, .close = board_close,
  .publisher = board_publisher, .publish = board_publish, .close_publisher = board_close_publisher,
  .subscription = board_subscription, .close_subscription = board_close_subscription,
};
