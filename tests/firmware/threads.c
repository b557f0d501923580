// Twenty threads pass numbers through a queue with a mutex and conditions, sleep, and write down who got which number.
#include <arpa/inet.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>
static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t filled = PTHREAD_COND_INITIALIZER, emptied = PTHREAD_COND_INITIALIZER;
static int queue[4], count, left = 400;
static char order[8192];
static void *give(void *number) {
  for (int i = 0; i < 40; i++) {
    pthread_mutex_lock(&mutex);
    while (count == 4) pthread_cond_wait(&emptied, &mutex);
    queue[count++] = (int)(long)number;
    if (i % 11 == 0) usleep(100);  // the others wait for the mutex meanwhile
    pthread_cond_signal(&filled);
    pthread_mutex_unlock(&mutex);
    if (i % 7 == (int)(long)number % 7) usleep(300);
  }
  return NULL;
}
static void *take(void *number) {
  for (;;) {
    pthread_mutex_lock(&mutex);
    while (!count && left) pthread_cond_wait(&filled, &mutex);
    if (!left) break;
    left--;
    sprintf(order + strlen(order), "%d<%d ", (int)(long)number, queue[--count]);
    if (!left) pthread_cond_broadcast(&filled);
    pthread_cond_broadcast(&emptied);
    pthread_mutex_unlock(&mutex);
    if (left % 5 == 0) usleep(1000);
  }
  pthread_mutex_unlock(&mutex);
  return NULL;
}
int main(void) {
  pthread_t threads[20];
  for (long i = 0; i < 20; i++) pthread_create(&threads[i], NULL, i < 10 ? give : take, (void *)i);
  for (int i = 0; i < 20; i++) pthread_join(threads[i], NULL);
  struct sockaddr_in there = {.sin_family = AF_INET, .sin_port = htons(4002), .sin_addr.s_addr = inet_addr("127.0.0.1")};
  sendto(socket(AF_INET, SOCK_DGRAM, 0), order, strlen(order), 0, (struct sockaddr *)&there, sizeof there);
  for (;;) sleep(1);
}
