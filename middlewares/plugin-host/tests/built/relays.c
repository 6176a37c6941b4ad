/*
 * Requests between the daemons of one process: each backend is an end, with its number as identity. */
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

struct genom_mw_backend { char identity[24]; };
struct genom_mw_announced {
  genom_mw_backend *at;
  char *name;
  void *to;
  int passing; /* requests that are being given to the host */
  genom_mw_announced *next;
};
struct genom_mw_relayed { int replied, closed, holders; void *reply; size_t len; };

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t changed = PTHREAD_COND_INITIALIZER;
static genom_mw_announced *all;

static int is(genom_mw_str s, const char *text)
{
  return s.len == strlen(text) && !memcmp(s.ptr, text, s.len);
}

static genom_mw_str str(const char *text) { return (genom_mw_str){ text, strlen(text) }; }

static genom_mw_code relays_open(const genom_mw_host *h, genom_mw_str options,
                                 genom_mw_backend **made, genom_mw_error *error)
{
  static int ends;
  (void)options, (void)error, host = h;
  *made = malloc(sizeof **made);
  snprintf((*made)->identity, sizeof (*made)->identity, "end %d",
           __atomic_add_fetch(&ends, 1, __ATOMIC_SEQ_CST));
  return GENOM_MW_OK;
}

static void relays_close(genom_mw_backend *backend) { free(backend); }

static genom_mw_code relays_announce(genom_mw_backend *backend, genom_mw_str name, void *to,
                                     genom_mw_announced **made, genom_mw_error *error)
{
  genom_mw_code code = GENOM_MW_OK;
  (void)error;
  pthread_mutex_lock(&lock);
  for (genom_mw_announced *one = all; one; one = one->next)
    if (is(name, one->name)) code = GENOM_MW_TAKEN;
  if (code == GENOM_MW_OK) {
    *made = malloc(sizeof **made);
    **made = (genom_mw_announced){ backend, strndup(name.ptr, name.len), to, 0, all };
    all = *made;
  }
  pthread_mutex_unlock(&lock);
  if (code != GENOM_MW_OK) host->release(to);
  return code;
}

static void relays_close_announced(genom_mw_announced *announced)
{
  pthread_mutex_lock(&lock);
  genom_mw_announced **at = &all;
  while (*at != announced) at = &(*at)->next;
  *at = announced->next;
  while (announced->passing) pthread_cond_wait(&changed, &lock);
  pthread_mutex_unlock(&lock);
  host->release(announced->to);
  free(announced->name), free(announced);
}

/* The caller holds the lock. */
static void leave(genom_mw_relayed *relayed)
{
  if (--relayed->holders) return;
  free(relayed->reply), free(relayed);
}

static void relays_reply(genom_mw_relayed *relayed, genom_mw_bytes reply)
{
  pthread_mutex_lock(&lock);
  relayed->reply = malloc(reply.len + 1);
  memcpy(relayed->reply, reply.len ? reply.ptr : "", relayed->len = reply.len);
  relayed->replied = 1;
  pthread_cond_broadcast(&changed);
  pthread_mutex_unlock(&lock);
}

static void relays_close_relayed(genom_mw_relayed *relayed)
{
  pthread_mutex_lock(&lock);
  relayed->closed = 1;
  pthread_cond_broadcast(&changed);
  leave(relayed);
  pthread_mutex_unlock(&lock);
}

static genom_mw_code relays_daemons(genom_mw_backend *backend, void *list, genom_mw_error *error)
{
  (void)backend, (void)error;
  pthread_mutex_lock(&lock);
  for (genom_mw_announced *one = all; one; one = one->next)
    host->text(list, str(one->name), str(""));
  pthread_mutex_unlock(&lock);
  return GENOM_MW_OK;
}

static void relays_own(genom_mw_backend *backend, void *list)
{
  host->text(list, str(backend->identity), str(""));
}

/* Asks the daemon of a name, at one end or, without `at`, wherever it is. */
static genom_mw_code ask(genom_mw_str name, const genom_mw_str *at, genom_mw_bytes request,
                         uint64_t patience, void *list, genom_mw_error *error)
{
  struct timespec end;
  clock_gettime(CLOCK_REALTIME, &end);
  end.tv_sec += patience / 1000000000, end.tv_nsec += patience % 1000000000;
  if (end.tv_nsec >= 1000000000) end.tv_sec++, end.tv_nsec -= 1000000000;
  pthread_mutex_lock(&lock);
  genom_mw_announced *one = all;
  while (one && !(is(name, one->name) && (!at || is(*at, one->at->identity)))) one = one->next;
  if (!one) {
    pthread_mutex_unlock(&lock);
    return at ? GENOM_MW_GONE : GENOM_MW_NOBODY;
  }
  genom_mw_relayed *relayed = calloc(1, sizeof *relayed);
  char identity[sizeof one->at->identity];
  memcpy(identity, one->at->identity, sizeof identity);
  relayed->holders = 2, one->passing++;
  pthread_mutex_unlock(&lock);
  host->relayed(one->to, relayed, request); /* may reply and close it at once */
  pthread_mutex_lock(&lock);
  one->passing--;
  pthread_cond_broadcast(&changed);
  int late = 0;
  while (!relayed->replied && !relayed->closed && !late)
    late = pthread_cond_timedwait(&changed, &lock, &end);
  genom_mw_code code = GENOM_MW_OK;
  if (relayed->replied)
    host->replied(list, str(identity), (genom_mw_bytes){ relayed->reply, relayed->len });
  else if (relayed->closed)
    code = at ? GENOM_MW_GONE : GENOM_MW_OK;
  else
    code = GENOM_MW_TIMEOUT, error->value = patience;
  leave(relayed);
  pthread_mutex_unlock(&lock);
  return code;
}

static genom_mw_code relays_ask_all(genom_mw_backend *backend, genom_mw_str name,
                                    genom_mw_bytes request, uint64_t patience, void *list,
                                    genom_mw_error *error)
{
  (void)backend;
  return ask(name, NULL, request, patience, list, error);
}

static genom_mw_code relays_ask(genom_mw_backend *backend, genom_mw_str name, genom_mw_str at,
                                genom_mw_bytes request, uint64_t patience, void *list,
                                genom_mw_error *error)
{
  (void)backend;
  return ask(name, &at, request, patience, list, error);
}

#define RELAYS .capabilities = GENOM_MW_RELAY, .open = relays_open, .close = relays_close, \
  .announce = relays_announce, .close_announced = relays_close_announced, \
  .reply_relayed = relays_reply, .close_relayed = relays_close_relayed, \
  .daemons = relays_daemons, .own = relays_own, .ask_all = relays_ask_all, .ask = relays_ask
