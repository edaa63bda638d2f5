"""Routes of robots' rule files and roles."""

from fastapi import APIRouter, Response
from pydantic import BaseModel, ConfigDict, Field

from app.agents.rules import RuledRobot
from app.api.bodies import Request
from app.api.etags import IfMatch, etag_of, version_of
from app.api.goals import ACTOR
from app.api.parameters import Id
from app.api.problems import declared
from app.api.services import AppServices
from app.api.worlds import TAGS
from app.missions.roles import RobotRole
from robots.wire import MAX_RULE_FILES, RuleText
from robots.world import RoleSpec
from robots.world.parts import Name, Tag


class SetRules(Request):
    """The robot's rule files, by the name of the agent or role that each defines; agents in order of rank."""

    files: dict[str, RuleText] = Field(
        max_length=MAX_RULE_FILES,
        examples=[{"guard": "AGENT guard;\nBELIEF(startup) => COMMIT(adoptBelief(on_duty));\n"}],
    )
    comment: str = Field(default="", max_length=2000)


class SetRole(Request):
    """The robot's role: what it is recruited for, the rules that it follows in it, and a home that it brings."""

    role: Name = Field(examples=["guard"])
    tags: list[Tag] | None = Field(
        default=None,
        max_length=256,
        description="the packets of its repertoire that plans may use it for; null: all",
        examples=[["NAVIGATE"]],
    )
    home: Name | None = Field(default=None, description="where it is charged in this role; null: as it was")
    rules: RuleText | None = Field(
        default=None,
        description="the text of the role's rule file; null: that of its name among the robot's rules, or the shipped "
        "one, or none",
        examples=["ROLE guard;\nBELIEF(startup) => COMMIT(adoptBelief(on_duty));\n"],
    )
    comment: str = Field(default="", max_length=2000)


class RulesBody(BaseModel):
    model_config = ConfigDict(from_attributes=True)

    robot: str
    world: str
    version: int
    files: dict[str, str] = Field(description="the text of each file, by the name of its agent or role")
    role: str = Field(description="that is sent with the files; empty: none")
    role_files: dict[str, str] = Field(description="the texts that the role adds, by name")
    digests: dict[str, str] = Field(description="of all these files, by name")
    followed: dict[str, str] = Field(description="digests of the files that the robot said to follow")
    delivery: str = Field(description="untouched, pending, acknowledged or refused by the robot")
    detail: str = Field(description="why the robot refused them")
    comment: str
    decided_by: str | None
    decided_at: str | None


class RoleBody(BaseModel):
    model_config = ConfigDict(from_attributes=True)

    robot: str
    world: str
    version: int
    role: str | None = Field(description="null: it plays none")
    tags: list[str] | None = Field(
        description="the packets that it is recruited for; null: all of its repertoire"
    )
    home: str | None = Field(description="the home that the role brings; null: it brings none")
    rules: str | None = Field(description="the text of the role's rule file, if one was stated")
    played: str = Field(description="the role that the robot said to play; empty: none")
    rules_version: int = Field(description="of the rules by which the robot was told")
    delivery: str = Field(
        description="of these rules: untouched, pending, acknowledged or refused by the robot"
    )
    detail: str = Field(description="why the robot refused them")
    comment: str
    decided_by: str | None
    decided_at: str | None
    home_kept: str = Field(
        description="in the answer to a change: why the robot keeps its home though the role that brought it ends; "
        "empty: it has its former one again, or the role had brought none"
    )


def robot_rules_router() -> APIRouter:
    router = APIRouter(prefix="/v1", tags=TAGS)

    @router.get("/robots/{name}/rules")
    def get_rules(services: AppServices, name: Id, response: Response) -> RulesBody:
        """The robot's rule files, and what it has answered to them."""
        return _rules(services.rules.get(name), response)

    @router.put("/robots/{name}/rules", responses=declared(412))
    def set_rules(
        services: AppServices, name: Id, body: SetRules, response: Response, if_match: IfMatch = None
    ) -> RulesBody:
        """Have the robot follow these rule files, which replace the earlier ones; none: no rules.

        Faults are refused by file, line and column. With `If-Match`, only if they were not changed since (412).
        Delivery is repeated until the robot answers, and again when its world starts again. A robot that refuses them
        goes on to follow what it followed before.
        """
        ruled = services.rules.put(
            name, body.files, actor=ACTOR, comment=body.comment, expected_version=version_of(if_match)
        )
        return _rules(ruled, response)

    @router.get("/robots/{name}/role")
    def get_role(services: AppServices, name: Id, response: Response) -> RoleBody:
        """The robot's role, and whether the robot knows of it."""
        return _role(services.roles.get(name), response)

    @router.put("/robots/{name}/role", responses=declared(409, 412))
    def set_role(
        services: AppServices, name: Id, body: SetRole, response: Response, if_match: IfMatch = None
    ) -> RoleBody:
        """Give the robot a role: all of it or, refused with the reason, nothing.

        It is recruited for its tags alone from now on: goals that need more of it wait, plans that use it otherwise are
        out of date; its mission goes on. Its agents believe `role(NAME)` once it has agreed, as with rules. With
        `If-Match`, only if the role was not changed since (412).
        """
        given = RoleSpec(
            name=body.role, tags=None if body.tags is None else tuple(body.tags), rules=body.rules
        )
        return _role(
            services.roles.put(
                name,
                given,
                home=body.home,
                actor=ACTOR,
                comment=body.comment,
                expected_version=version_of(if_match),
            ),
            response,
        )

    @router.delete("/robots/{name}/role", responses=declared(409, 412))
    def clear_role(services: AppServices, name: Id, response: Response, if_match: IfMatch = None) -> RoleBody:
        """End the robot's role: it is recruited for all that it can, and has the home again that it had before."""
        ended = services.roles.put(name, None, actor=ACTOR, comment="", expected_version=version_of(if_match))
        return _role(ended, response)

    return router


def _role(role: RobotRole, response: Response) -> RoleBody:
    response.headers["etag"] = etag_of(role.version)
    return RoleBody.model_validate(role)


def _rules(ruled: RuledRobot, response: Response) -> RulesBody:
    response.headers["etag"] = etag_of(ruled.version)
    return RulesBody.model_validate(ruled)
