// Blocks in every way that the other two do not: semaphores, conditions with a time, `select` over a connection that it
// accepts, `poll`, joins, and a child which asks it for something.  It tells when each of them ended.
#include <arpa/inet.h>
#include <poll.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>
static int out;
static sem_t posted;
static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t condition = PTHREAD_COND_INITIALIZER;
static struct sockaddr_un served = {.sun_family = AF_UNIX, .sun_path = "served"};
static struct timespec after_ns(long ns) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  t.tv_nsec += ns;
  return (struct timespec){t.tv_sec + t.tv_nsec / 1000000000, t.tv_nsec % 1000000000};
}
static void say(const char *form, ...) {
  char text[256];
  va_list more;
  va_start(more, form);
  struct sockaddr_in there = {.sin_family = AF_INET, .sin_port = htons(4002)};
  int size = snprintf(text, sizeof text, "%.6f ", 1e-9 * after_ns(0).tv_nsec);
  size += vsnprintf(text + size, sizeof text - size, form, more);
  sendto(out, text, size, 0, (struct sockaddr *)&there, sizeof there);
}
static void *post(void *us) {
  for (int i = 0; i < 4; i++) usleep((long)us), sem_post(&posted);
  pthread_exit(us);
}
static void *take(void *number) {
  for (int i = 0; i < 4; i++) {
    struct timespec until = after_ns(900000);
    int late = sem_timedwait(&posted, &until);
    say("taker %ld %s", (long)number, late ? "late" : "in time");
    if (late) sem_wait(&posted);
  }
  return number;
}
static void *wait_timed(void *number) {
  for (int i = 0; i < 4; i++) {
    struct timespec until = after_ns(2000000);
    pthread_mutex_lock(&mutex);
    int late = pthread_cond_timedwait(&condition, &mutex, &until);
    pthread_mutex_unlock(&mutex);
    say("waiter %ld %s", (long)number, late ? "late" : "in time");
  }
  return number;
}
static void *signal_it(void *number) {
  for (int i = 0; i < 5; i++) {
    usleep(1000 * i);
    i % 2 ? pthread_cond_signal(&condition) : pthread_cond_broadcast(&condition);
  }
  return number;
}
static void *answer_network(void *unused) {
  int listener = socket(AF_INET, SOCK_STREAM, 0);
  struct sockaddr_in here = {.sin_family = AF_INET, .sin_port = htons(4001)};
  bind(listener, (struct sockaddr *)&here, sizeof here);
  listen(listener, 1);
  for (int fd = accept(listener, NULL, NULL);;) {
    char heard[8] = "";
    fd_set reads;
    FD_ZERO(&reads);
    FD_SET(fd, &reads);
    int found = select(fd + 1, &reads, NULL, NULL, &(struct timeval){0, 30000});
    say("select %d %s", found, found && read(fd, heard, 6) > 0 ? heard : "-");
  }
}
static void *answer_children(void *unused) {
  int listener = socket(AF_UNIX, SOCK_STREAM, 0);
  bind(listener, (struct sockaddr *)&served, sizeof served);
  listen(listener, 1);
  for (;;) {
    char heard[8] = "";
    int fd = accept(listener, NULL, NULL);
    read(fd, heard, 6);
    say("asked %s", heard);
    usleep(20000);  // this takes time, although a child is at work
    write(fd, "done", 4);
    close(fd);
  }
}
int main(int count, char **words) {
  if (count > 1) {  // the child
    char heard[8] = "";
    int fd = socket(AF_UNIX, SOCK_STREAM, 0);
    usleep(30000);
    connect(fd, (struct sockaddr *)&served, sizeof served);
    usleep(30000);
    write(fd, "please", 6);
    return read(fd, heard, 4) == 4 ? 7 : 8;
  }
  out = socket(AF_INET, SOCK_DGRAM, 0);
  sem_init(&posted, 0, 0);
  pthread_t ids[8];
  void *(*starts[8])(void *) = {answer_network, answer_children, post, post, take, take, wait_timed, signal_it};
  for (long i = 0; i < 8; i++) pthread_create(&ids[i], NULL, starts[i], (void *)(i < 4 ? 350 * i : i));
  for (int i = 2; i < 8; i++) {
    void *result = NULL;
    pthread_join(ids[i], &result);
    say("joined %ld", (long)result);
  }
  char command[512];
  snprintf(command, sizeof command, "'%s' child; exit $?", words[0]);
  say("child %d", system(command) >> 8);
  for (int ms = 0;; ms += 5) say("poll %d", poll(&(struct pollfd){.fd = -1}, 1, ms));
}
