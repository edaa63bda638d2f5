(define (domain logistics)
  (:requirements :strips :typing)
  (:types place thing - object truck plane - thing package - thing city)
  (:predicates (in-city ?p - place ?c - city) (airport ?p - place) (at ?t - thing ?p - place) (in ?k - package ?v - thing))
  (:action drive
    :parameters (?t - truck ?a - place ?b - place ?c - city)
    :precondition (and (at ?t ?a) (in-city ?a ?c) (in-city ?b ?c))
    :effect (and (at ?t ?b) (not (at ?t ?a))))
  (:action fly
    :parameters (?t - plane ?a - place ?b - place)
    :precondition (and (at ?t ?a) (airport ?a) (airport ?b))
    :effect (and (at ?t ?b) (not (at ?t ?a))))
  (:action loadt
    :parameters (?k - package ?v - truck ?a - place)
    :precondition (and (at ?k ?a) (at ?v ?a))
    :effect (and (in ?k ?v) (not (at ?k ?a))))
  (:action loadp
    :parameters (?k - package ?v - plane ?a - place)
    :precondition (and (at ?k ?a) (at ?v ?a))
    :effect (and (in ?k ?v) (not (at ?k ?a))))
  (:action unloadt
    :parameters (?k - package ?v - truck ?a - place)
    :precondition (and (in ?k ?v) (at ?v ?a))
    :effect (and (at ?k ?a) (not (in ?k ?v))))
  (:action unloadp
    :parameters (?k - package ?v - plane ?a - place)
    :precondition (and (in ?k ?v) (at ?v ?a))
    :effect (and (at ?k ?a) (not (in ?k ?v)))))
